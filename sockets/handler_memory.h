// SPDX-License-Identifier: Apache-2.0
// HandlerMemory: room for one handler of Asio's, taken beforehand. What a server cannot go on without, that it takes
// connections and hears of bytes, is awaited again also when the system gives no memory: who waits there for memory waits
// for what the same thread would set free.
//
//     acceptor.async_accept(with(memory, [](error_code, tcp::socket) { ... }));
//
// One thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>

#include "base/check.h"

namespace seaway::sockets {

class HandlerMemory {
  public:
    /// A handler lies in it, which will be called, or has been lost with an exception of Asio's own if this says no.
    bool in_use() const { return in_use_; }

    void* take(std::size_t bytes) {
        SEAWAY_CHECK(!in_use_ && bytes <= room_.size(), "one handler, as large as Asio makes it");
        in_use_ = true;
        return room_.data();
    }
    void give_back() { in_use_ = false; }

  private:
    alignas(std::max_align_t) std::array<std::byte, 1024> room_{};
    bool in_use_ = false;
};

/// Asio frees handlers that nobody called when its context goes, which may outlive whoever awaited them.
using HandlerMemoryPtr = std::shared_ptr<HandlerMemory>;

template <class T>
struct HandlerAllocator {
    using value_type = T;

    explicit HandlerAllocator(HandlerMemoryPtr of) : memory(std::move(of)) {}
    template <class Other>
    HandlerAllocator(const HandlerAllocator<Other>& other)
        : memory(other.memory) {} // NOLINT(google-explicit-constructor)

    T* allocate(std::size_t count) { return static_cast<T*>(memory->take(count * sizeof(T))); }
    void deallocate(T*, std::size_t) { memory->give_back(); }
    template <class Other>
    bool operator==(const HandlerAllocator<Other>& other) const {
        return memory == other.memory;
    }

    HandlerMemoryPtr memory;
};

/// `handler`, which Asio keeps in `memory`.
template <class Handler>
class HandlerWithMemory {
  public:
    using allocator_type = HandlerAllocator<void>;

    HandlerWithMemory(HandlerMemoryPtr memory, Handler handler)
        : memory_(std::move(memory)), handler_(std::move(handler)) {}

    allocator_type get_allocator() const noexcept { return allocator_type(memory_); }
    template <class... Arguments>
    void operator()(Arguments&&... arguments) {
        handler_(std::forward<Arguments>(arguments)...);
    }

  private:
    HandlerMemoryPtr memory_;
    Handler handler_;
};

template <class Handler>
HandlerWithMemory<Handler> with(const HandlerMemoryPtr& memory, Handler handler) {
    return {memory, std::move(handler)};
}

} // namespace seaway::sockets
