// SPDX-License-Identifier: Apache-2.0
// Nothing: the target that this file makes up holds the precompiled headers of all tests.
