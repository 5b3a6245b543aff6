// SPDX-License-Identifier: Apache-2.0
#include "sockets/name_lookup.h"

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include <boost/asio/post.hpp>
#include <dlfcn.h>
#include <netdb.h>

#include "base/quiet_thread.h"
#include "base/thread_name.h"

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
    Done take() {
        const std::scoped_lock lock(mutex);
        return loop != nullptr ? std::exchange(done, nullptr) : nullptr;
    }
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
    keep_this_library();
    const QuietThreads quiet;
    std::thread([asked = asked_, host, port]() noexcept {
        name_thread("sea-lookup");
        try {
            Asked::tell(asked, now(host, port));
        } catch (const std::bad_alloc&) { // who asked has a deadline
        }
    }).detach();
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
