// SPDX-License-Identifier: Apache-2.0
// What the passes of bloom share: levels of half the size, one after the other in a buffer.

struct BloomLevel {
    int first; // texel
    int columns;
    int lines;
};

layout(push_constant) uniform Push {
    BloomLevel from;
    BloomLevel to;
    int pixels;  // of the picture a texel of the finest level, a side: 2 or 4
    float share; // of a level that comes from the coarser ones
} push;

/// Where invocation n works; false beyond the last.
bool place_of(int n, out ivec2 at) {
    at = ivec2(n % push.to.columns, n / push.to.columns);
    return n < push.to.columns * push.to.lines;
}
