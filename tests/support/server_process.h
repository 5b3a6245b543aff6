// SPDX-License-Identifier: Apache-2.0
// seaway-server as a child process on loopback and a free port; stopped by its process id.
#pragma once

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/read_file.h"

namespace seaway::tests {

/// Of "ws://127.0.0.1:9430".
inline int port_of(const std::string& url) {
    return std::stoi(url.substr(url.rfind(':') + 1));
}

class ServerProcess {
  public:
    /// Starts `seaway-server ARGUMENTS...`; the log goes to a file of its own, or where `log_to` leads.
    explicit ServerProcess(std::vector<std::string> arguments, int log_to = -1,
                           const std::string& program = SEAWAY_BIN_DIR "/seaway-server")
        : log_is_elsewhere_(log_to >= 0) {
        char name[] = "/tmp/seaway-server-log-XXXXXX";
        const int log = mkstemp(name);
        log_path_ = name;
        int out[2];
        if (pipe2(out, O_CLOEXEC) != 0)
            std::abort();
        arguments.insert(arguments.begin(), program);
        std::vector<char*> argv;
        for (std::string& argument : arguments)
            argv.push_back(argument.data());
        argv.push_back(nullptr);
        pid_ = fork();
        if (pid_ == 0) {
            dup2(out[1], STDOUT_FILENO);
            dup2(log_to >= 0 ? log_to : log, STDERR_FILENO);
            if (chdir(SEAWAY_SOURCE_DIR) == 0)
                execv(argv[0], argv.data());
            _exit(127);
        }
        close(out[1]);
        close(log);
        out_ = out[0];
    }
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;
    ~ServerProcess() {
        if (pid_ > 0) {
            kill(pid_, SIGKILL);
            waitpid(pid_, nullptr, 0);
        }
        close(out_);
        std::remove(log_path_.c_str());
    }

    /// "ws://127.0.0.1:PORT" once it serves; empty if it ended or took longer.
    std::string wait_until_ready(std::chrono::seconds limit = std::chrono::seconds(120)) {
        std::string line;
        const auto deadline = std::chrono::steady_clock::now() + limit;
        while (line.find('\n') == std::string::npos) {
            const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
                deadline - std::chrono::steady_clock::now());
            pollfd readable{out_, POLLIN, 0};
            char byte = 0;
            if (left.count() <= 0 || poll(&readable, 1, static_cast<int>(left.count())) <= 0 ||
                read(out_, &byte, 1) != 1)
                return {};
            line += byte;
        }
        // Its log is written by a thread of its own: the line that says where it serves may come a moment later.
        for (int i = 0; i < 1000 && !log_is_elsewhere_ && log().find("url=") == std::string::npos;
             ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        constexpr std::string_view ready = "ready ";
        return line.starts_with(ready) ? line.substr(ready.size(), line.size() - ready.size() - 1)
                                       : std::string{};
    }

    void send(int signal) const { kill(pid_, signal); }
    pid_t pid() const { return pid_; }

    /// The exit code, or nothing if it still runs when the limit has passed.
    std::optional<int> wait_for_exit(std::chrono::milliseconds limit) {
        const auto deadline = std::chrono::steady_clock::now() + limit;
        while (std::chrono::steady_clock::now() < deadline) {
            int status = 0;
            if (waitpid(pid_, &status, WNOHANG) == pid_) {
                pid_ = -1;
                return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return std::nullopt;
    }

    std::string log() const { return read_file(log_path_); }

  private:
    pid_t pid_ = -1;
    int out_ = -1;
    std::string log_path_;
    bool log_is_elsewhere_;
};

} // namespace seaway::tests
