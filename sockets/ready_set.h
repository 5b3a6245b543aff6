// SPDX-License-Identifier: Apache-2.0
// ReadySet: which of many sockets something has come to, asked of the system for many at a time. A service of an
// io_context, found by the sockets themselves. Beside Asio's own way, which reads until nothing is left, an arrival costs one
// read, no allocation below its handler and no turn of the loop of its own: a server of a thousand readers takes twenty
// thousand acknowledgements a second.
//
// Of the io_context's one thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>

#include <boost/asio/execution_context.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/system/error_code.hpp>

#include "sockets/handler_memory.h"

namespace seaway::sockets {

class ReadySet : public boost::asio::execution_context::service {
  public:
    using error_code = boost::system::error_code;
    /// What has come, until the handler returns; after an error, which the end of the stream is too, nothing.
    using Handler = std::function<void(error_code, std::span<std::uint8_t>)>;
    using Id = std::uint64_t;

    static inline boost::asio::execution_context::id id;
    /// Of the context of an io_context.
    explicit ReadySet(boost::asio::execution_context& context);
    ~ReadySet() override;

    /// A socket that stays open until it has been removed.
    Id add(int handle);
    /// Calls once, never within this call. One at a time for each socket. An error: the system has no room for
    /// it, and nothing will be called.
    [[nodiscard]] error_code receive(Id member, Handler handler);
    /// What is awaited is called with operation_aborted, not within this call. Takes no memory: so ends whom the system
    /// gave none.
    void remove(Id member) noexcept;

  private:
    struct Member {
        int handle = -1;
        Handler handler;
        bool watched = false;
        Id removed_before = 0; ///< of one that is removed, and will be told
    };
    void shutdown() override;
    void arm() noexcept;
    bool armed() const { return memory_->in_use(); }
    void on_ready();
    void ask_who();
    /// The bytes that came.
    std::size_t give(Id member);
    void tell_later() noexcept;
    void tell_removed();
    bool watch(Id id, Member& member);
    void watch_no_more(Member& member);

    std::unordered_map<Id, Member> members_;
    Id next_ = 1;
    Id removed_ = 0; ///< the last one that will be told, which leads to the others
    int epoll_ = -1;
    /// Of one turn: what others have posted waits for no more.
    static constexpr std::size_t arrivals_a_turn = 16;
    /// With this much a turn is over, too: an arrival that fills the buffer may be hundreds of messages.
    static constexpr std::size_t bytes_a_turn = 4 * 1024;
    std::array<Id, arrivals_a_turn> named_{}; ///< by the system, to whom something has come
    std::size_t named_count_ = 0;
    std::size_t given_ = 0; ///< of these; the others come first in the next turn
    boost::asio::io_context& loop_;
    boost::asio::posix::stream_descriptor ready_;
    std::size_t waiting_ = 0; ///< handlers
    const HandlerMemoryPtr memory_ = std::make_shared<HandlerMemory>();
    const HandlerMemoryPtr telling_ = std::make_shared<HandlerMemory>();
    std::array<std::uint8_t, 16 * 1024> bytes_{};
};

} // namespace seaway::sockets
