// SPDX-License-Identifier: Apache-2.0
#include "sockets/frame_reader.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace seaway::sockets {
namespace {

// RFC 6455, 5.2
constexpr std::uint8_t last_bit = 0x80;
constexpr std::uint8_t reserved_bits = 0x70;
constexpr std::uint8_t opcode_bits = 0x0f;
constexpr std::uint8_t mask_bit = 0x80;
constexpr std::uint8_t length_bits = 0x7f;
constexpr std::size_t control_bytes_max = 125;
constexpr std::size_t mask_bytes = 4;

namespace opcode {
constexpr std::uint8_t more = 0x0;
constexpr std::uint8_t text = 0x1;
constexpr std::uint8_t binary = 0x2;
constexpr std::uint8_t close = 0x8;
constexpr std::uint8_t ping = 0x9;
constexpr std::uint8_t pong = 0xa;
} // namespace opcode

Error against_protocol(std::string_view why) {
    return {BadFrame::against_protocol, std::string(why)};
}

std::size_t length_bytes(std::uint8_t length) {
    return length < 126 ? 0 : length == 126 ? 2 : 8;
}

/// Bytes of a payload from its byte `at` on. Eight at a time: a query of thousands of points is 100 KB.
void unmask(std::span<std::uint8_t> bytes, const std::uint8_t* mask, std::size_t at) {
    std::array<std::uint8_t, 8> turned{};
    for (std::size_t i = 0; i < turned.size(); ++i)
        turned[i] = mask[(at + i) % mask_bytes];
    std::uint64_t eight = 0;
    std::memcpy(&eight, turned.data(), sizeof(eight));
    std::size_t i = 0;
    for (; i + sizeof(eight) <= bytes.size(); i += sizeof(eight)) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, sizeof(word));
        word ^= eight;
        std::memcpy(bytes.data() + i, &word, sizeof(word));
    }
    for (; i < bytes.size(); ++i)
        bytes[i] ^= turned[i % turned.size()];
}

/// What the header of a frame says of its payload, where all of the header is there.
std::uint64_t announced_length(std::span<const std::uint8_t> header) {
    const std::size_t announced = length_bytes(header[1] & length_bits);
    if (announced == 0)
        return header[1] & length_bits;
    std::uint64_t length = 0;
    for (const std::uint8_t byte : header.subspan(2, announced))
        length = length << 8 | byte;
    return length;
}

/// Codes that a closing frame may have (RFC 6455, 7.4, and IANA's registry: 1012 to 1014).
bool is_sent(unsigned code) {
    const bool reserved = code == 1004 || code == 1005 || code == 1006;
    return (code >= 1000 && code <= 1014 && !reserved) || (code >= 3000 && code <= 4999);
}

/// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::span<const std::uint8_t> bytes) {
    for (std::size_t i = 0; i < bytes.size();) {
        const std::uint8_t first = bytes[i];
        const std::size_t more = first < 0x80                    ? 0
                                 : first >= 0xc2 && first < 0xe0 ? 1
                                 : first >= 0xe0 && first < 0xf0 ? 2
                                 : first >= 0xf0 && first < 0xf5 ? 3
                                                                 : bytes.size();
        if (more >= bytes.size() - i)
            return false;
        for (std::size_t j = 1; j <= more; ++j)
            if ((bytes[i + j] & 0xc0) != 0x80)
                return false;
        const std::uint8_t second = more > 0 ? bytes[i + 1] : 0;
        if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
            (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90))
            return false;
        i += more + 1;
    }
    return true;
}

} // namespace

std::size_t FrameReader::header_bytes() const {
    return header_read_ < 2 ? 2 : 2 + length_bytes(header_[1] & length_bits) + mask_bytes;
}

Result<std::optional<FrameReader::Frame>> FrameReader::next(std::span<const std::uint8_t>& bytes) {
    if (message_given_) {
        message_.clear();
        if (message_.capacity() > kept_bytes_)
            message_.shrink_to_fit();
        message_given_ = false;
    }
    while (true) {
        while (!in_payload_) {
            const std::size_t missing = header_bytes() - header_read_;
            const std::size_t taken = std::min(missing, bytes.size());
            std::copy_n(bytes.begin(), taken, header_.begin() + header_read_);
            header_read_ += taken;
            bytes = bytes.subspan(taken);
            if (taken < missing)
                return std::optional<Frame>();
            if (header_read_ == 2)
                SEAWAY_TRY(check_start());
            else
                SEAWAY_TRY(begin_payload());
        }
        take_payload(bytes);
        if (payload_left_ > 0)
            return std::optional<Frame>();
        if (const std::optional<Frame> whole = end_frame())
            return whole;
    }
}

/// A part of a message that ends none, or one that has not come whole, may be followed by nothing for long.
bool FrameReader::gives_message(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < 2 || (bytes[0] & last_bit) == 0 || (bytes[0] & opcode_bits) > opcode::binary)
        return false;
    const std::size_t header = 2 + length_bytes(bytes[1] & length_bits) + mask_bytes;
    return bytes.size() >= header && bytes.size() - header >= announced_length(bytes);
}

/// What the first two bytes of a frame say.
Result<void> FrameReader::check_start() {
    ++frames_begun_;
    last_ = (header_[0] & last_bit) != 0;
    opcode_ = header_[0] & opcode_bits;
    if ((header_[0] & reserved_bits) != 0)
        return against_protocol("a frame uses an extension that was not agreed");
    if ((header_[1] & mask_bit) == 0)
        return against_protocol("a client's frame is not masked");
    switch (opcode_) {
    case opcode::more:
        if (!in_message_)
            return against_protocol("a frame continues no message");
        return {};
    case opcode::text:
    case opcode::binary:
        if (in_message_)
            return against_protocol("a message begins within another");
        in_message_ = true;
        binary_ = opcode_ == opcode::binary;
        return {};
    case opcode::close:
    case opcode::ping:
    case opcode::pong:
        if (!last_ || (header_[1] & length_bits) > control_bytes_max)
            return against_protocol("a control frame is not whole or too long");
        control_.clear();
        return {};
    default:
        return against_protocol(fmt::format("a frame of unknown kind {}", opcode_));
    }
}

/// Judges the length before any of what it announces is held.
Result<void> FrameReader::begin_payload() {
    const std::size_t announced = length_bytes(header_[1] & length_bits);
    const std::uint64_t length = announced_length(header_);
    if (announced > 0 && (length < (announced == 2 ? 126u : 65536u) || (length >> 63) != 0))
        return against_protocol("a frame's length is not in its shortest form");
    if (opcode_ <= opcode::binary && length > message_bytes_max_ - message_.size())
        return Error{BadFrame::too_large,
                     fmt::format("a message of more than {} bytes", message_bytes_max_)};
    payload_left_ = static_cast<std::size_t>(length);
    mask_at_ = 0;
    in_payload_ = true;
    return {};
}

void FrameReader::take_payload(std::span<const std::uint8_t>& bytes) {
    std::vector<std::uint8_t>& into = opcode_ >= opcode::close ? control_ : message_;
    const std::size_t taken = std::min(payload_left_, bytes.size());
    const std::size_t before = into.size();
    into.insert(into.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(taken));
    unmask(std::span(into).subspan(before), header_.data() + header_read_ - mask_bytes, mask_at_);
    mask_at_ += taken;
    payload_left_ -= taken;
    bytes = bytes.subspan(taken);
}

/// None: of a message more frames follow.
std::optional<FrameReader::Frame> FrameReader::end_frame() {
    in_payload_ = false;
    header_read_ = 0;
    switch (opcode_) {
    case opcode::close:
        return Frame{Kind::close, control_};
    case opcode::ping:
        return Frame{Kind::ping, control_};
    case opcode::pong:
        return Frame{Kind::pong, control_};
    default:
        if (!last_)
            return {};
        in_message_ = false;
        message_given_ = true;
        return Frame{Kind::message, message_, binary_};
    }
}

Result<CloseReason> read_close(std::span<const std::uint8_t> bytes) {
    if (bytes.empty())
        return CloseReason{};
    const unsigned code = bytes.size() < 2 ? 0 : bytes[0] << 8 | bytes[1];
    if (!is_sent(code))
        return against_protocol("a closing frame without a code that may be sent");
    const std::span<const std::uint8_t> reason = bytes.subspan(2);
    if (!is_utf8(reason))
        return against_protocol("a closing frame's reason is not UTF-8");
    return CloseReason{code, std::string(reason.begin(), reason.end())};
}

std::vector<std::uint8_t> control_frame(FrameReader::Kind kind,
                                        std::span<const std::uint8_t> bytes) {
    const std::uint8_t of_kind = kind == FrameReader::Kind::close  ? opcode::close
                                 : kind == FrameReader::Kind::ping ? opcode::ping
                                                                   : opcode::pong;
    const std::size_t length = std::min(bytes.size(), control_bytes_max);
    std::vector<std::uint8_t> frame{static_cast<std::uint8_t>(last_bit | of_kind),
                                    static_cast<std::uint8_t>(length)};
    frame.insert(frame.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    return frame;
}

std::vector<std::uint8_t> close_frame(const CloseReason& why) {
    std::vector<std::uint8_t> bytes;
    if (why.code != 0) {
        bytes = {static_cast<std::uint8_t>(why.code >> 8), static_cast<std::uint8_t>(why.code)};
        std::size_t length = std::min(why.reason.size(), control_bytes_max - bytes.size());
        while (length < why.reason.size() && length > 0 && (why.reason[length] & 0xc0) == 0x80)
            --length; // not within a character
        bytes.insert(bytes.end(), why.reason.begin(),
                     why.reason.begin() + static_cast<std::ptrdiff_t>(length));
    }
    return control_frame(FrameReader::Kind::close, bytes);
}

} // namespace seaway::sockets
