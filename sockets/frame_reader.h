// SPDX-License-Identifier: Apache-2.0
// FrameReader: what a WebSocket client sends (RFC 6455, 5), from bytes as they come to whole messages and
// control frames. Without sockets, timers or a thread. No extension is spoken; text is not looked into, whoever takes
// messages declines it whole.
//
// What it holds grows with the bytes that have come, never with a length that was announced.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace seaway::sockets {

/// Kinds of errors, each of which ends the connection with the status that RFC 6455, 7.4.1 gives it.
enum class BadFrame {
    against_protocol = 1002,
    too_large = 1009,
};

class FrameReader {
  public:
    enum class Kind { message, ping, pong, close };
    struct Frame {
        Kind kind = Kind::message;
        std::span<const std::uint8_t> bytes; ///< until the next call
        bool binary = true;                  ///< of a message
    };

    /// A message of more bytes, in however many frames, is an error as soon as that is known. What held a larger one than
    /// kept_bytes is given back before the next.
    explicit FrameReader(std::size_t message_bytes_max,
                         std::size_t kept_bytes = std::numeric_limits<std::size_t>::max())
        : message_bytes_max_(message_bytes_max), kept_bytes_(kept_bytes) {}

    /// The next message or control frame that is whole. What it has read is taken from the front of `bytes`; none: all
    /// of them, and more are needed. After an error nothing is to be read.
    Result<std::optional<Frame>> next(std::span<const std::uint8_t>& bytes);
    /// Of what follows a whole frame: next() gives a message of it, or an error, not nothing and no control frame.
    static bool gives_message(std::span<const std::uint8_t> bytes);
    /// Of any kind, parts of messages included.
    std::uint64_t frames_begun() const { return frames_begun_; }

  private:
    Result<void> check_start();
    Result<void> begin_payload();
    std::optional<Frame> end_frame();
    std::size_t header_bytes() const;
    void take_payload(std::span<const std::uint8_t>& bytes);

    std::size_t message_bytes_max_;
    std::size_t kept_bytes_;
    std::array<std::uint8_t, 14> header_{};
    std::size_t header_read_ = 0;
    std::uint64_t frames_begun_ = 0;
    bool in_payload_ = false;
    std::size_t payload_left_ = 0;
    std::uint8_t opcode_ = 0;
    bool last_ = false;
    std::size_t mask_at_ = 0;
    std::vector<std::uint8_t> message_;
    bool in_message_ = false;
    bool binary_ = true;
    bool message_given_ = false;
    std::vector<std::uint8_t> control_;
};

/// What a closing frame holds.
struct CloseReason {
    unsigned code = 0; ///< 0: it said none
    std::string reason;
};

/// Of the bytes of a frame of Kind::close; an error where they are against RFC 6455, 5.5.1 and 7.4.
Result<CloseReason> read_close(std::span<const std::uint8_t> bytes);

/// A control frame as a server sends it; of `bytes` at most 125.
std::vector<std::uint8_t> control_frame(FrameReader::Kind kind,
                                        std::span<const std::uint8_t> bytes);
/// A closing one; the reason is cut at what a frame holds. Code 0: neither.
std::vector<std::uint8_t> close_frame(const CloseReason& why);

} // namespace seaway::sockets
