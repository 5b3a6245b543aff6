// SPDX-License-Identifier: Apache-2.0
// Clients of a NetServer over real loopback sockets: WebSocket, HTTP, and bytes of any kind. They are
// written from RFC 6455 and RFC 9112, not with the library that the server uses: what both ends would
// get wrong alike is seen, and compiling them takes a second.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

#include "protocol/messages.h"

namespace seaway::tests {

/// A WebSocket client whose every operation ends when its patience does, at the latest.
class Client {
  public:
    /// `from`: an address of this machine, such as 127.0.0.2. `patience`: as long as a crowded machine may need; less where what is
    /// waited for may never come.
    explicit Client(int port, std::string from = {},
                    std::chrono::milliseconds patience = std::chrono::minutes(1));
    ~Client();

    /// `fields`: more lines of the upgrade's header, each with its line end.
    std::error_code connect(const std::string& subprotocol = "seaway.v1",
                            const std::string& fields = {});
    std::error_code send(const protocol::Bytes& bytes);

    /// The next message, valid until the next call; null with error() set. After `timed_out` it may be called again.
    const wire::Message* receive();
    const wire::Message* receive(std::chrono::milliseconds wait);
    /// Skips what is not wanted, for at most 10 000 messages.
    const wire::Message* receive(wire::Body kind);
    bool greet(std::string_view token = "");

    /// Reads, answering pings underneath; false if a message or an end comes. The last call.
    bool stays_quiet_for(std::chrono::milliseconds wait);
    /// Reads to the end and returns the close code, 0 if there was none.
    unsigned close_code();

    std::error_code error() const;
    /// What the upgrade was answered with.
    int status() const;
    std::string field(const std::string& name) const; ///< of that answer
    std::string subprotocol() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A bare TCP connection to say anything with.
class RawPeer {
  public:
    explicit RawPeer(int port, int receive_buffer_bytes = 0, const std::string& from = {});
    ~RawPeer();

    void say(std::span<const std::uint8_t> bytes);
    void say(std::string_view text);
    /// Upgrades by hand and reads the response's header.
    void upgrade();
    /// A masked binary frame with key 0, whole or cut after `bytes_sent` bytes of it.
    void frame(const protocol::Bytes& payload, std::size_t bytes_sent = ~std::size_t{0});
    void reset(); ///< RST instead of FIN
    /// Reads to the end of an HTTP header.
    std::string header();
    /// Reads this much; false: the server has closed its side before.
    bool reads(std::size_t bytes);
    /// Reads until the server has closed its side, in order or not.
    std::string rest();
    bool closed_by_server();        ///< the same, for those who do not ask what came
    bool ended_in_order() const;    ///< after rest(): FIN, not RST
    std::size_t bytes_read() const; ///< of everything, headers included

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A masked closing frame with key 0 (RFC 6455, 5.5.1).
inline std::string closing_frame(unsigned code, const std::string& reason) {
    std::string frame{'\x88', static_cast<char>(0x80 | (2 + reason.size()))};
    frame += std::string(4, '\0');
    frame += static_cast<char>(code >> 8);
    frame += static_cast<char>(code & 0xff);
    return frame + reason;
}

struct HttpAnswer {
    int status = 0;
    std::string body;
    std::map<std::string, std::string> fields; ///< by name, as the server writes it
};

/// One request on a connection of its own.
HttpAnswer ask_http(int port, const std::string& target, const std::string& method,
                    const std::string& authorization = {}, const std::string& from = {});

} // namespace seaway::tests
