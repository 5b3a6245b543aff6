// SPDX-License-Identifier: Apache-2.0
// ServedWebSocket: the server's end of a WebSocket. The handshake is Beast's; frames are read by
// FrameReader, from what ReadySet says has come, and written as they lie, so that a message costs one call to
// the system and nothing else that counts.
//
// Of one thread, that of the socket's executor, which also runs the callbacks. At most one read() is under
// way; whoever owns it keeps it until each has called back, and callbacks that own the owner see to that.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "base/result.h"
#include "sockets/frame_reader.h"
#include "sockets/socket.h"
#include "sockets/web_socket.h"

namespace seaway::sockets {

struct Upgrade;

class ServedWebSocket {
  public:
    using Done = std::function<void(Result<void>)>;
    using Message = WebSocket::Message;
    using Read = std::function<void(const Result<Message>&)>;

    ServedWebSocket(Socket socket, const WebSocketOptions& options);
    ~ServedWebSocket();
    ServedWebSocket(ServedWebSocket&&) noexcept;
    ServedWebSocket& operator=(ServedWebSocket&&) = delete;

    /// Answers a client's request. Errors have the reason alone as message.
    void accept(const Upgrade& upgrade, Done done);

    /// Of one arrival, which may hold hundreds: then others have their turn, and what is left waits behind them.
    static constexpr int messages_a_turn = 16;

    /// The next message, or an error of a kind of WebSocketEnd, behind which there is none. Pings are answered; where
    /// nothing is read, they are not. While an answer has not gone and a second one waits nothing more is received.
    /// What throws out of `done` has read nothing: a read() within it is forgotten.
    void read(Read done);
    /// After an error of kind `closed` or `not_understood`: says the last word, unless it has been said, and waits for the peer
    /// to go, for handshake_patience at most. Closed at once, the system would throw away what the peer has not read yet.
    void leave(std::function<void()> done);

    /// Several messages, each in one binary frame, in one call to the system, as far as it takes them without waiting.
    /// True: all of them have gone. False: finish() has to follow.
    /// `same`, if not empty, has the same frames with their headers (frame_header.h), and is not copied.
    [[nodiscard]] bool begin(std::span<const std::span<const std::uint8_t>> messages,
                             const FileRange& same = {});
    /// Sends more of what begin() began, whole messages, some 64 KiB of them. `done` has true: that was the rest; until then the
    /// messages stay, and finish() follows.
    using Finished = std::function<void(Result<bool>)>;
    void finish(Finished done);
    /// Sends the closing frame, behind what is being written. Whoever reads is told `closed` when the peer has answered it;
    /// messages may come before.
    void close(const CloseReason& why);

    /// What the peer's closing frame said; after an error of kind `closed`.
    const CloseReason& peer_close() const;
    Socket& socket();

  private:
    struct Impl;
    std::shared_ptr<Impl> impl_;
};

} // namespace seaway::sockets
