// SPDX-License-Identifier: Apache-2.0
// Completion: completion handlers of every type as one type, so that the templates over handlers below
// a socket are compiled once. Each costs an allocation, which beside its system call is nothing.
#pragma once

#include <concepts>
#include <memory>
#include <utility>

namespace seaway::sockets {

/// Called once at the most, with how an operation ended. Moves, does not copy. Of the handler's
/// associated executor, allocator and cancellation slot nothing is kept: it runs on the executor of
/// the socket that was asked.
template <class... Values>
class Completion {
  public:
    template <class Handler>
    requires(!std::same_as<Handler, Completion>) explicit Completion(Handler handler)
        : held_(std::make_unique<Held<Handler>>(std::move(handler))) {}

    void operator()(Values... values) {
        Any& any = *held_;
        any.complete(std::move(held_), values...);
    }

  private:
    struct Any {
        virtual ~Any() = default;
        /// Gives its memory back before it calls: what the handler starts may take it.
        virtual void complete(std::unique_ptr<Any> self, Values... values) = 0;
    };
    template <class Handler>
    struct Held final : Any {
        explicit Held(Handler taken) : handler(std::move(taken)) {}
        void complete(std::unique_ptr<Any> self, Values... values) override {
            Handler taken(std::move(handler));
            self.reset();
            taken(values...);
        }
        Handler handler;
    };
    std::unique_ptr<Any> held_;
};

} // namespace seaway::sockets
