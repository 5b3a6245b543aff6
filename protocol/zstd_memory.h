// SPDX-License-Identifier: Apache-2.0
// zstd says by a null pointer or by a code that there is no memory. Here that is std::bad_alloc, as of everybody else:
// whoever asked is refused, and the process goes on. For .cpp files of this room.
#pragma once

#include <memory>
#include <new>

#include <zstd.h>
#include <zstd_errors.h>

namespace seaway::protocol {

struct FreeZstd {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
using ZstdEncoder = std::unique_ptr<ZSTD_CCtx, FreeZstd>;
using ZstdDecoder = std::unique_ptr<ZSTD_DCtx, FreeZstd>;

/// `held`, made by `make` where it is empty.
template <class Owner, class Make>
typename Owner::pointer made(Owner& held, Make make) {
    if (held == nullptr)
        held.reset(make());
    return held != nullptr ? held.get() : throw std::bad_alloc();
}

/// What zstd returned: bytes, or an error of another kind.
inline std::size_t unless_no_memory(std::size_t returned) {
    return ZSTD_getErrorCode(returned) == ZSTD_error_memory_allocation ? throw std::bad_alloc()
                                                                       : returned;
}

} // namespace seaway::protocol
