// SPDX-License-Identifier: Apache-2.0
// NameLookup: the addresses of a name, looked up on a thread that nobody waits for. The system may take half a minute and cannot
// be called off: who asks Asio instead waits for it when its context goes. Of one name one look-up is under way in a process,
// whoever asks meanwhile: who tries again and again beside a system that hangs keeps one thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include "base/result.h"

namespace seaway::sockets {

/// Of one thread, that of its loop.
class NameLookup {
  public:
    using Endpoints = boost::asio::ip::tcp::resolver::results_type;
    /// An error is what the system says.
    using Done = std::function<void(const Result<Endpoints>&)>;

    explicit NameLookup(boost::asio::io_context& loop);
    /// Whoever asked is not told any more. Does not wait.
    ~NameLookup();
    NameLookup(const NameLookup&) = delete;
    NameLookup& operator=(const NameLookup&) = delete;

    /// Once; `done` is called on the loop, never within this call. Addresses take no thread. `port`: decimal. Throws
    /// std::system_error where there is no thread.
    void begin(const std::string& host, const std::string& port, Done done);

    /// The same here and now, for as long as the system takes.
    static Result<Endpoints> now(const std::string& host, const std::string& port);

  private:
    struct Asked;
    class UnderWay;
    const std::shared_ptr<Asked> asked_; ///< shared with the thread
};

} // namespace seaway::sockets
