// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "protocol/zstd_memory.h"

namespace seaway::protocol {
namespace {

// Naive: a null pointer is handed on, and a code of no memory is a broken tile or the end of the process.
TEST(ZstdMemory, none_is_bad_alloc_whichever_way_it_is_said) {
    ZstdEncoder encoder;
    ZstdDecoder decoder;
    EXPECT_THROW(made(encoder, [] { return static_cast<ZSTD_CCtx*>(nullptr); }), std::bad_alloc);
    EXPECT_THROW(made(decoder, [] { return static_cast<ZSTD_DCtx*>(nullptr); }), std::bad_alloc);
    const ZSTD_DCtx* const first = made(decoder, ZSTD_createDCtx);
    EXPECT_EQ(made(decoder, ZSTD_createDCtx), first) << "made once";

    const auto code = [](ZSTD_ErrorCode of) {
        return static_cast<std::size_t>(0) - static_cast<std::size_t>(of);
    };
    EXPECT_THROW(unless_no_memory(code(ZSTD_error_memory_allocation)), std::bad_alloc);
    for (const std::size_t other :
         {std::size_t{0}, std::size_t{7}, code(ZSTD_error_corruption_detected)})
        EXPECT_EQ(unless_no_memory(other), other);
}

} // namespace
} // namespace seaway::protocol
