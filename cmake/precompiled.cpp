// SPDX-License-Identifier: Apache-2.0
// Nothing: a target that compiles headers once for others needs a source.
