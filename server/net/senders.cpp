// SPDX-License-Identifier: Apache-2.0
#include "server/net/senders.h"

#include <array>
#include <new>
#include <utility>

namespace seaway::server {

NoBrokenPipes::NoBrokenPipes() {
    sigset_t broken_pipes;
    sigemptyset(&broken_pipes);
    sigaddset(&broken_pipes, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &broken_pipes, &before_);
}

NoBrokenPipes::~NoBrokenPipes() {
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Senders::start(int threads) {
    if (threads <= 1)
        return;
    const NoBrokenPipes none;
    pool_ = std::make_unique<ThreadPool>(threads, "sea-senders");
}

bool Senders::later(std::shared_ptr<Sending> one) {
    if (pool_ == nullptr || !gathers_)
        return false;
    waiting_.push_back(std::move(one));
    return true;
}

void Senders::send() noexcept {
    sending_.swap(waiting_);
    std::erase_if(sending_, [](const std::shared_ptr<Sending>& one) { return !one->take(); });
    const auto write = [](const void* context, int chunk, int) {
        const auto& of = *static_cast<const std::vector<std::shared_ptr<Sending>>*>(context);
        of[static_cast<std::size_t>(chunk)]->write();
    };
    try {
        if (!sending_.empty())
            pool_->run(std::array{Phase{write, &sending_, static_cast<int>(sending_.size())}});
    } catch (const std::bad_alloc&) { // of its first run: nothing has been written
        for (const std::shared_ptr<Sending>& one : sending_)
            one->write();
    }
    for (const std::shared_ptr<Sending>& one : sending_)
        one->written();
    sending_.clear();
}

} // namespace seaway::server
