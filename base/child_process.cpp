// SPDX-License-Identifier: Apache-2.0
#include "base/child_process.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace seaway {

namespace {

constexpr const char* missing = "there is no such program";

} // namespace

Result<ChildProcess> ChildProcess::start(const std::vector<std::string>& words) {
    int ends[2]; // sockets, because a pipe without a reader would end this program
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return Error{std::string("cannot make a pipe: ") + std::strerror(errno)};
    std::vector<char*> arguments;
    for (const std::string& word : words)
        arguments.push_back(const_cast<char*>(word.c_str())); // exec does not write there
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    pid_t process = -1;
    const int failure =
        posix_spawnp(&process, words[0].c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (failure == 0)
        return ChildProcess(process, ends[0]);
    ::close(ends[0]);
    return Error{failure == ENOENT ? missing : std::strerror(failure)};
}

bool ChildProcess::is_missing(const Error& error) {
    return error.message == missing;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : process_(std::exchange(other.process_, -1)), input_(std::exchange(other.input_, -1)) {}

ChildProcess::~ChildProcess() {
    if (process_ < 0)
        return;
    ::kill(process_, SIGTERM);
    wait();
}

Result<void> ChildProcess::write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return Error{"it has ended"};
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return {};
}

ChildProcess::End ChildProcess::wait() {
    ::close(std::exchange(input_, -1));
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return WIFEXITED(status) ? End{false, WEXITSTATUS(status)} : End{true, WTERMSIG(status)};
}

} // namespace seaway
