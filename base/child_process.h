// SPDX-License-Identifier: Apache-2.0
// ChildProcess: a program beside us that reads what we write. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace seaway {

class ChildProcess {
  public:
    /// words[0] is the program, looked for in PATH. Its standard output and error are ours. An error: it cannot be
    /// started; is_missing() of it says that there is none of that name.
    static Result<ChildProcess> start(const std::vector<std::string>& words);
    static bool is_missing(const Error& error);

    ChildProcess(ChildProcess&& other) noexcept;
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;
    /// One that was not waited for is asked to end (SIGTERM), and waited for.
    ~ChildProcess();

    /// To its standard input; waits until it has taken it. An error: it has ended or closed its input. No SIGPIPE.
    Result<void> write(std::span<const std::uint8_t> bytes);

    /// How it ended.
    struct End {
        bool by_signal = false;
        int code = 0; ///< exit status, or the signal
    };
    /// Closes its input and waits until it ends.
    End wait();

  private:
    ChildProcess(int process, int input) : process_(process), input_(input) {}
    int process_ = -1;
    int input_ = -1;
};

} // namespace seaway
