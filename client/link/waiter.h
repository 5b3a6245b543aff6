// SPDX-License-Identifier: Apache-2.0
// What blocking calls wait with: a Connection answers each request once, at the latest when its patience has ended.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <utility>

#include "client/link/requests.h"

namespace seaway::client {

/// A ReplyHandler to wait for.
class Waiter {
  public:
    ReplyHandler handler() {
        return [promise = promise_](Result<Reply> reply) { promise->set_value(std::move(reply)); };
    }
    bool ready() const {
        return reply_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    }
    Result<Reply> wait() { return reply_.get(); }

  private:
    std::shared_ptr<std::promise<Result<Reply>>> promise_ =
        std::make_shared<std::promise<Result<Reply>>>();
    std::future<Result<Reply>> reply_ = promise_->get_future();
};

} // namespace seaway::client
