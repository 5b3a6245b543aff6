// SPDX-License-Identifier: Apache-2.0
#include "sockets/ready_set.h"

#include <cerrno>
#include <utility>

#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "base/check.h"

namespace seaway::sockets {

namespace asio = boost::asio;

ReadySet::ReadySet(asio::execution_context& context)
    : service(context), epoll_(::epoll_create1(EPOLL_CLOEXEC)),
      loop_(static_cast<asio::io_context&>(context)), ready_(loop_) {
    boost::system::error_code ignored; // without a handle every receive() says so
    ready_.assign(epoll_, ignored);
}

ReadySet::~ReadySet() = default;

/// Handlers own what owns the sockets that ask for them.
void ReadySet::shutdown() {
    std::unordered_map<Id, Member> last;
    last.swap(members_);
    waiting_ = 0;
    removed_ = 0;
    boost::system::error_code ignored;
    ready_.close(ignored);
}

ReadySet::Id ReadySet::add(int handle) {
    const Id made = next_++;
    members_[made].handle = handle;
    return made;
}

ReadySet::error_code ReadySet::receive(Id which, Handler handler) {
    Member& member = members_.at(which);
    SEAWAY_CHECK(!member.handler, "one at a time is received");
    if (!member.watched && !watch(which, member))
        return asio::error::no_descriptors;
    member.handler = std::move(handler);
    ++waiting_;
    if (!armed())
        arm();
    return {};
}

void ReadySet::remove(Id which) noexcept {
    const auto found = members_.find(which);
    if (found == members_.end())
        return;
    Member& member = found->second;
    if (!member.handler) {
        watch_no_more(member);
        members_.erase(found);
        return;
    }
    if (!member.watched)
        return; // removed already
    watch_no_more(member);
    --waiting_;
    member.removed_before = std::exchange(removed_, which);
    tell_later();
    if (waiting_ == 0 && armed()) {
        boost::system::error_code ignored;
        ready_.cancel(ignored); // an io_context with nothing else to do comes to its end
    }
}

void ReadySet::tell_later() noexcept {
    if (!telling_->in_use())
        asio::post(loop_, with(telling_, [this] { tell_removed(); }));
}

void ReadySet::tell_removed() {
    struct TellTheOthers { // also behind a handler that throws
        ReadySet& set;
        ~TellTheOthers() {
            if (set.removed_ != 0)
                set.tell_later();
        }
    } const others{*this};
    while (removed_ != 0) {
        const auto found = members_.find(removed_);
        removed_ = found->second.removed_before;
        const Handler handler = std::move(found->second.handler);
        members_.erase(found);
        handler(asio::error::operation_aborted, {});
    }
}

bool ReadySet::watch(Id which, Member& member) {
    epoll_event event{};
    event.events = EPOLLIN | EPOLLRDHUP;
    event.data.u64 = which;
    member.watched = epoll_ >= 0 && ::epoll_ctl(epoll_, EPOLL_CTL_ADD, member.handle, &event) == 0;
    return member.watched;
}

/// A socket that nobody reads is taken out: the system reports one that is gone whether asked for or not.
void ReadySet::watch_no_more(Member& member) {
    if (std::exchange(member.watched, false))
        ::epoll_ctl(epoll_, EPOLL_CTL_DEL, member.handle, nullptr);
}

void ReadySet::arm() noexcept {
    ready_.async_wait(asio::posix::stream_descriptor::wait_read,
                      with(memory_, [this](boost::system::error_code) { on_ready(); }));
}

void ReadySet::on_ready() {
    struct
        ArmAgain { // also behind a handler that throws; what it was in the way of is reported again
        ReadySet& set;
        ~ArmAgain() {
            if (set.waiting_ > 0 && !set.armed())
                set.arm();
        }
    } const again{*this};
    if (given_ == named_count_)
        ask_who();
    for (std::size_t came = 0; given_ < named_count_ && came < bytes_a_turn;)
        came += give(named_[given_++]);
}

/// Not before all whom it named were given theirs: it puts them behind all others.
void ReadySet::ask_who() {
    std::array<epoll_event, arrivals_a_turn> events{};
    const int count = ::epoll_wait(epoll_, events.data(), arrivals_a_turn, 0);
    given_ = named_count_ = 0;
    for (; static_cast<int>(named_count_) < count; ++named_count_)
        named_[named_count_] = events[named_count_].data.u64;
}

std::size_t ReadySet::give(Id which) {
    const auto found = members_.find(which);
    if (found == members_.end())
        return 0; // removed by a handler of this turn, or since the last one
    Member& member = found->second;
    if (!member.handler || !member.watched) {
        watch_no_more(member);
        return 0;
    }
    const ssize_t received = ::recv(member.handle, bytes_.data(), bytes_.size(), MSG_DONTWAIT);
    const bool nothing = received < 0 && (errno == EAGAIN || errno == EINTR);
    if (nothing)
        return 0;
    boost::system::error_code error;
    if (received < 0)
        error.assign(errno, boost::system::system_category());
    else if (received == 0)
        error = asio::error::eof;
    Handler handler = std::move(member.handler);
    member.handler = nullptr;
    --waiting_;
    const std::size_t came = received > 0 ? static_cast<std::size_t>(received) : 0;
    handler(error, {bytes_.data(), came});
    return came;
}

} // namespace seaway::sockets
