// SPDX-License-Identifier: Apache-2.0
// nats-server with JetStream as a child process on loopback, with a store folder of its own; stopped by its process id.
#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/folder.h"
#include "tests/support/free_port.h"

namespace seaway::tests {

class NatsServer {
  public:
    /// `config`: lines of its configuration besides port and store.
    explicit NatsServer(const std::string& config = "", bool with_log = true)
        : port_(free_port()), store_(folder().fresh(fmt::format("nats-{}", port_))),
          jetstream_(with_log ? fmt::format("jetstream {{ store_dir: \"{}\" }}\n", store_) : "") {
        start(config);
    }
    ~NatsServer() { stop(SIGKILL); }
    NatsServer(const NatsServer&) = delete;
    NatsServer& operator=(const NatsServer&) = delete;

    /// The same with another configuration.
    bool start(const std::string& config) {
        config_ = folder().write(
            fmt::format("nats-{}.conf", port_),
            fmt::format("listen: \"127.0.0.1:{}\"\n{}{}\n", port_, jetstream_, config));
        return start();
    }
    /// On the same port, with what it has stored. True: it takes connections.
    bool start() {
        pid_ = fork();
        if (pid_ == 0) {
            const int log = open((store_ + ".log").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
            dup2(log, STDOUT_FILENO);
            dup2(log, STDERR_FILENO);
            // Debian has it where only root's path leads.
            execl("/usr/sbin/nats-server", "nats-server", "-c", config_.c_str(), nullptr);
            _exit(127);
        }
        for (int i = 0; i < 2000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
            if (answers())
                return true;
        return false;
    }
    void stop(int signal = SIGTERM) {
        if (pid_ <= 0)
            return;
        kill(pid_, signal);
        waitpid(pid_, nullptr, 0);
        pid_ = -1;
    }
    void send(int signal) const { kill(pid_, signal); }

    /// What comes in answer to a request within two seconds, with what NATS says around it; else empty.
    std::string ask(const std::string& subject, const std::string& body = {}) const {
        const int socket_of = connected();
        const std::string question =
            fmt::format("CONNECT {{\"verbose\":false}}\r\nSUB _INBOX.ask 1\r\n"
                        "PUB {} _INBOX.ask {}\r\n{}\r\n",
                        subject, body.size(), body);
        const timeval patience{2, 0};
        setsockopt(socket_of, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        (void)::send(socket_of, question.data(), question.size(), MSG_NOSIGNAL);
        std::string text;
        char bytes[4096];
        for (ssize_t n = 0; text.find("}\r\n", text.find("MSG ")) == std::string::npos &&
                            (n = recv(socket_of, bytes, sizeof bytes, 0)) > 0;)
            text.append(bytes, static_cast<std::size_t>(n));
        close(socket_of);
        const std::size_t answer = text.find("MSG ");
        return answer == std::string::npos ? "" : text.substr(answer);
    }

    int port() const { return port_; }
    const std::string& store() const { return store_; }
    std::string url(const std::string& world) const { return url(port_, world); }
    static std::string url(int port, const std::string& world) {
        return fmt::format("nats://127.0.0.1:{}/{}", port, world);
    }

  private:
    /// A socket; of one that is not connected nothing comes.
    int connected() const {
        const int socket_of = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address.sin_port = htons(static_cast<std::uint16_t>(port_));
        (void)connect(socket_of, reinterpret_cast<sockaddr*>(&address), sizeof address);
        return socket_of;
    }
    bool answers() const {
        const int socket_of = connected();
        char info[4] = {};
        const bool said = recv(socket_of, info, sizeof info, MSG_WAITALL) == 4;
        close(socket_of);
        return said && std::string(info, 4) == "INFO";
    }

    const int port_;
    const std::string store_, jetstream_;
    std::string config_;
    pid_t pid_ = -1;
};

} // namespace seaway::tests
