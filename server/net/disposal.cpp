// SPDX-License-Identifier: Apache-2.0
#include "server/net/disposal.h"

#include <utility>

#include "base/thread_name.h"

namespace seaway::server {

void Disposal::stop() {
    {
        const std::scoped_lock lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable())
        thread_.join();
}

void Disposal::take(Things one) {
    {
        const std::scoped_lock lock(mutex_);
        if (ending_)
            return;
        things_.splice(things_.end(), one);
    }
    wake_.notify_one();
}

void Disposal::run() {
    name_thread("sea-disposal");
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return ending_ || !things_.empty(); });
        if (things_.empty())
            return;
        std::shared_ptr<void> thing = std::move(things_.front());
        things_.pop_front();
        lock.unlock();
        thing = nullptr;
        lock.lock();
    }
}

} // namespace seaway::server
