// SPDX-License-Identifier: Apache-2.0
#include "sockets/name_lookup.h"

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/post.hpp>
#include <dlfcn.h>
#include <netdb.h>

#include "base/quiet_thread.h"
#include "base/thread_name.h"
#include "base/undo.h"

namespace seaway::sockets {

namespace asio = boost::asio;

namespace {

/// Nothing: that is no address.
std::optional<NameLookup::Endpoints> address(const std::string& host, const std::string& port) {
    boost::system::error_code no_address;
    const asio::ip::address address = asio::ip::make_address(host, no_address);
    std::uint16_t number = 0;
    const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (no_address || problem != std::errc() || end != port.data() + port.size())
        return std::nullopt;
    return NameLookup::Endpoints::create({address, number}, host, port);
}

/// A library that is unloaded while one of its threads is still in it takes the program with it.
void keep_this_library() {
    Dl_info here{};
    if (::dladdr(reinterpret_cast<const void*>(&address), &here) != 0 && here.dli_fname != nullptr)
        ::dlopen(here.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE); // of a program: nothing
}

} // namespace

struct NameLookup::Asked {
    std::mutex mutex;
    asio::io_context* loop; ///< null: nobody wants to know
    Done done;

    /// On any thread.
    static void tell(const std::shared_ptr<Asked>& asked, Result<Endpoints> found) {
        const std::scoped_lock lock(asked->mutex);
        if (asked->loop != nullptr)
            asio::post(*asked->loop, [asked, found = std::move(found)] {
                if (const Done due = asked->take())
                    due(found);
            });
    }
    bool has_left() {
        const std::scoped_lock lock(mutex);
        return loop == nullptr;
    }
    Done take() {
        const std::scoped_lock lock(mutex);
        return loop != nullptr ? std::exchange(done, nullptr) : nullptr;
    }
};

/// Who waits for which name. Of each name one look-up is under way, however often it is asked for: one that hangs keeps one thread.
class NameLookup::UnderWay {
  public:
    using Name = std::pair<std::string, std::string>; ///< host and port
    using Waiting = std::vector<std::shared_ptr<Asked>>;

    /// Never destroyed: threads outlive main().
    static UnderWay& all() {
        static auto* const all = new UnderWay;
        return *all;
    }
    /// True: it is the first, and has to be looked up.
    bool add(const Name& name, const std::shared_ptr<Asked>& asked) {
        const std::scoped_lock lock(mutex_);
        const auto [at, first] = waiting_.try_emplace(name);
        Undo no_room([&, at = at, first = first] {
            if (first)
                waiting_.erase(at);
        });
        std::erase_if(at->second, [](const auto& one) { return one->has_left(); });
        at->second.push_back(asked);
        no_room.keep();
        return first;
    }
    /// It has been looked up.
    void tell(const Name& name, const Result<Endpoints>& found) noexcept {
        for (const std::shared_ptr<Asked>& one : take(name))
            try {
                Asked::tell(one, found);
            } catch (const std::bad_alloc&) { // who asked has a deadline
            }
    }

  private:
    Waiting take(const Name& name) noexcept {
        const std::scoped_lock lock(mutex_);
        const auto found = waiting_.find(name);
        Waiting waiting = std::move(found->second);
        waiting_.erase(found);
        return waiting;
    }

    std::mutex mutex_;
    std::map<Name, Waiting> waiting_;
};

NameLookup::NameLookup(asio::io_context& loop) : asked_(std::make_shared<Asked>()) {
    asked_->loop = &loop;
}

NameLookup::~NameLookup() {
    const std::scoped_lock lock(asked_->mutex);
    asked_->loop = nullptr;
}

void NameLookup::begin(const std::string& host, const std::string& port, Done done) {
    asked_->done = std::move(done);
    if (auto known = address(host, port))
        return Asked::tell(asked_, *std::move(known));
    const UnderWay::Name name(host, port);
    if (!UnderWay::all().add(name, asked_))
        return;
    keep_this_library();
    const QuietThreads quiet;
    Undo nobody_looks([&] {
        (void)asked_->take(); // who asks is told by what is thrown
        UnderWay::all().tell(name, Error{"no thread"});
    });
    std::thread([name]() noexcept {
        name_thread("sea-lookup");
        try {
            UnderWay::all().tell(name, now(name.first, name.second));
        } catch (const std::bad_alloc&) {
            UnderWay::all().tell(name, Error{"no memory"}); // these texts take none
        }
    }).detach();
    nobody_looks.keep();
}

Result<NameLookup::Endpoints> NameLookup::now(const std::string& host, const std::string& port) {
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_STREAM;
    wanted.ai_protocol = IPPROTO_TCP;
    addrinfo* found = nullptr;
    const int problem = ::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found);
    if (problem != 0)
        return Error{problem == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(problem)};
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> held(found, ::freeaddrinfo);
    return Endpoints::create(found, host, port);
}

} // namespace seaway::sockets
