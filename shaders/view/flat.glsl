// SPDX-License-Identifier: Apache-2.0
// The number of an invocation of gpu::Commands::dispatch_all, row after row of groups.
#include "shared/view.h"

int flat_invocation() {
    return int(gl_GlobalInvocationID.y * gl_NumWorkGroups.x * uint(view_group) + gl_GlobalInvocationID.x);
}
