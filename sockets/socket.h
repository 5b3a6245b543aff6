// SPDX-License-Identifier: Apache-2.0
// Socket: a TCP connection, plain or TLS, as one type that Asio and Beast take for a stream. Which of
// both it is, and of what type a handler is, is decided when it runs: templates over streams are
// compiled once, and the layers below this one in socket.cpp alone.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>

#include "sockets/completion.h"

namespace boost::asio::ssl {
class context;
}
namespace boost::beast {
enum class role_type;
}

namespace seaway::sockets {

using boost::system::error_code;

/// Bytes of an open file.
struct FileRange {
    int handle = -1;
    std::uint64_t begin = 0;
    std::size_t bytes = 0;
};

/// The first buffers of a sequence that are not empty: what one call to the system takes.
template <class Buffer>
class FewBuffers {
  public:
    template <class Sequence>
    explicit FewBuffers(const Sequence& sequence) {
        const auto end = boost::asio::buffer_sequence_end(sequence);
        for (auto at = boost::asio::buffer_sequence_begin(sequence); at != end && count_ < held_max;
             ++at)
            if (const Buffer buffer(*at); buffer.size() > 0)
                held_[count_++] = buffer;
    }
    const Buffer* begin() const { return held_.data(); }
    const Buffer* end() const { return held_.data() + count_; }

  private:
    static constexpr std::size_t held_max = 16;
    std::array<Buffer, held_max> held_{};
    std::size_t count_ = 0;
};

/// Of one thread, that of its executor. Operations end with an error code and, reading and writing, a
/// number of bytes; their handlers run on that thread, never inside the call that starts them.
class Socket {
  public:
    using executor_type = boost::asio::any_io_executor;
    using Bytes = Completion<error_code, std::size_t>;
    using Done = std::function<void(error_code)>;
    using Received = std::function<void(error_code, std::span<std::uint8_t>)>;

    /// An accepted connection, or one still to be made.
    explicit Socket(boost::asio::ip::tcp::socket socket);
    /// The same for TLS; `tls` outlives it.
    Socket(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& tls);
    /// Closes it.
    ~Socket();
    Socket(Socket&&) noexcept;
    Socket& operator=(Socket&&) = delete;

    executor_type get_executor();
    bool has_tls() const;

    using Endpoints = boost::asio::ip::tcp::resolver::results_type;
    /// To the first of them that answers: each is tried when those before it have failed, or the one before has said nothing
    /// for Connecting::head_start. As long as all of them have is what expires_after() has said before. Programs that this one
    /// starts do not get it: they would keep the connection after this one has ended.
    void connect(const Endpoints& endpoints, Done done);
    /// The server's part of the TLS handshake; only where has_tls().
    void accept_tls(Done done);
    /// The client's part, which holds the host's name against the certificate; only where has_tls().
    void connect_tls(const std::string& host, Done done);
    /// What connect_tls() has failed by, in words: also what is wrong with the certificate that the peer showed.
    std::string words_of(const error_code& failed) const;

    /// What is under way, or begins before this is called again, ends with beast::error::timeout.
    void expires_after(std::chrono::milliseconds patience);
    void expires_never();

    /// From now on a write is whole before the next one begins, and goes out in the order in which it came.
    void write_whole();
    /// Only after write_whole(): the buffers, and what they are of, stay until `done`.
    void write_all(std::vector<boost::asio::const_buffer> buffers, Bytes done);
    /// Only after write_whole(): as many bytes of the first 64 buffers as the system takes at once, without waiting;
    /// 0 where another write is under way, over TLS, and where the connection is gone, which the next write_all() says.
    /// What was not taken has to follow by write_all() before anything else is written.
    std::size_t write_now(const std::vector<boost::asio::const_buffer>& buffers);
    /// The same of what lies in a file, whose bytes the system does not copy: they must not change any more. Where
    /// SIGPIPE is neither ignored nor blocked a peer that has gone raises it.
    std::size_t send_now(const FileRange& range);

    /// Only after write_whole(): what comes next, in a buffer that many share: until `done` returns. With an error,
    /// which the end of the stream is too, nothing. One at a time.
    void receive(Received done);
    /// The one that is under way ends with operation_aborted.
    void stop_receiving();
    /// The end of a connection whose protocol is over. It says no more, and takes unseen what the peer still sends: closed
    /// with a part of it unread, the system would have the peer throw away what it was told last. Closes when the peer has gone, after
    /// `patience`, or when the peer has sent parted_bytes_max more; then calls `gone`. Nothing else is under way meanwhile.
    static constexpr std::size_t parted_bytes_max = 4 << 20;
    void part(std::chrono::milliseconds patience, std::function<void()> gone);

    void set_no_delay();
    /// Something has come that nobody has read yet.
    bool has_unread() const;
    /// For poll and epoll alone; -1 before connect() and after close().
    int descriptor() const;
    /// No more is sent; what the peer still sends can be read.
    void shutdown_send();
    /// What is under way ends with an error.
    void close();

    // ---- what Asio and Beast call ----

    template <class Buffers, class Handler>
    void async_read_some(const Buffers& buffers, Handler&& handler) {
        read_some(FewBuffers<boost::asio::mutable_buffer>(buffers),
                  Bytes(std::forward<Handler>(handler)));
    }
    template <class Buffers, class Handler>
    void async_write_some(const Buffers& buffers, Handler&& handler) {
        write_some(FewBuffers<boost::asio::const_buffer>(buffers),
                   Bytes(std::forward<Handler>(handler)));
    }
    template <class Handler>
    friend void async_teardown(boost::beast::role_type role, Socket& socket, Handler&& handler) {
        socket.tear_down(role, Completion<error_code>(std::forward<Handler>(handler)));
    }
    friend void beast_close_socket(Socket& socket) { socket.close(); }

  private:
    bool takes_writes_now() const;
    void read_some(FewBuffers<boost::asio::mutable_buffer> buffers, Bytes done);
    void write_some(FewBuffers<boost::asio::const_buffer> buffers, Bytes done);
    void tear_down(boost::beast::role_type role, Completion<error_code> done);

    struct Streams;
    struct Parting;
    std::shared_ptr<Streams> streams_; ///< of this one, and of what is under way
};

} // namespace seaway::sockets
