// SPDX-License-Identifier: Apache-2.0
#include "sockets/connecting.h"

#include <iterator>
#include <utility>

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/error.hpp>
#include <fcntl.h>

namespace seaway::sockets {

namespace asio = boost::asio;
using boost::system::error_code;

Connecting::Connecting(const asio::any_io_executor& executor, tcp::resolver::results_type endpoints,
                       Done done)
    : executor_(executor), endpoints_(std::move(endpoints)), next_(endpoints_.begin()),
      pause_(executor), deadline_(executor), why_(asio::error::host_not_found),
      done_(std::move(done)) {}

void Connecting::begin(std::optional<Clock::time_point> until) {
    if (until) {
        deadline_.expires_at(*until);
        deadline_.async_wait([self = shared_from_this()](error_code called_off) {
            if (!called_off)
                self->end(boost::beast::error::timeout);
        });
    }
    asio::post(executor_, [self = shared_from_this()] { self->try_next(); });
}

void Connecting::give_up() {
    if (Done done = over())
        asio::post(executor_,
                   [done = std::move(done)] { done(asio::error::operation_aborted, {}); });
}

/// Asio would open the socket itself, and a program that is started meanwhile would get it.
void Connecting::try_next() {
    pause_.cancel();
    while (done_ && next_ != endpoints_.end()) {
        const tcp::endpoint endpoint = (next_++)->endpoint();
        tcp::socket opened(executor_);
        opened.open(endpoint.protocol(), why_);
        if (why_)
            continue;
        ::fcntl(opened.native_handle(), F_SETFD, FD_CLOEXEC);
        const auto which = tries_.insert(tries_.end(), std::move(opened));
        which->async_connect(endpoint, [self = shared_from_this(), which](error_code error) {
            self->on_answer(error, which);
        });
        if (next_ == endpoints_.end())
            return;
        pause_.expires_after(head_start);
        pause_.async_wait([self = shared_from_this()](error_code called_off) {
            if (!called_off)
                self->try_next();
        });
        return;
    }
    if (tries_.empty())
        end(why_);
}

void Connecting::on_answer(error_code error, std::list<tcp::socket>::iterator which) {
    if (!done_)
        return; // another was first
    tcp::socket socket = std::move(*which);
    tries_.erase(which);
    if (!error)
        return end({}, std::move(socket));
    why_ = error;
    try_next();
}

void Connecting::end(error_code error, std::optional<tcp::socket> connected) {
    if (const Done done = over())
        done(error, std::move(connected));
}

Connecting::Done Connecting::over() {
    pause_.cancel();
    deadline_.cancel();
    tries_.clear(); // which closes them
    return std::exchange(done_, nullptr);
}

} // namespace seaway::sockets
