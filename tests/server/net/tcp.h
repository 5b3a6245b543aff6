// SPDX-License-Identifier: Apache-2.0
// Tcp: a connection over loopback as the system gives it, so that a test can wait, stop or end anywhere.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <system_error>

namespace seaway::tests {

class Tcp {
  public:
    using Clock = std::chrono::steady_clock;

    Tcp();
    ~Tcp();
    Tcp(const Tcp&) = delete;
    Tcp& operator=(const Tcp&) = delete;

    /// An option of level SOL_SOCKET.
    void set(int option, const void* value, std::size_t size);
    /// `from`: an address of this machine to come from; all of 127.0.0.0/8 is.
    std::error_code connect(int port, const std::string& from = {});
    /// Everything, or an error; after `wait` without room for more it is `timed_out`.
    std::error_code write(std::span<const std::uint8_t> bytes, std::chrono::milliseconds wait);
    /// Appends what is there, at least a byte. The end in order is `no_message_available`; nothing
    /// until `end` is `timed_out`.
    std::error_code read(std::string& to, Clock::time_point end);
    void close();

  private:
    /// Waits for it; ends and errors count, too.
    bool ready(short what, Clock::time_point end) const;

    int descriptor_;
};

} // namespace seaway::tests
