// SPDX-License-Identifier: Apache-2.0
// Connecting: to the first of several addresses that answers. One that says nothing, as behind a firewall or in a network
// without a way out, does not keep the others from being tried (RFC 8305, "Happy Eyeballs"). Of one thread, that of its executor.
#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <optional>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

namespace seaway::sockets {

class Connecting : public std::enable_shared_from_this<Connecting> {
  public:
    using tcp = boost::asio::ip::tcp;
    using Clock = std::chrono::steady_clock;
    /// A socket that is connected, or none and why.
    using Done = std::function<void(boost::system::error_code, std::optional<tcp::socket>)>;

    /// The next address is tried when one has failed, or has not answered for so long (RFC 8305, 5).
    static constexpr std::chrono::milliseconds head_start{250};

    Connecting(const boost::asio::any_io_executor& executor, tcp::resolver::results_type endpoints,
               Done done);

    /// Calls `done` once, never within this call: with beast::error::timeout behind `until`; none: never for that.
    void begin(std::optional<Clock::time_point> until);
    /// `done` is called with operation_aborted, not within this call. Nothing where it has been called.
    void give_up();

  private:
    void try_next();
    void on_answer(boost::system::error_code error, std::list<tcp::socket>::iterator which);
    void end(boost::system::error_code error, std::optional<tcp::socket> connected = {});
    Done over(); ///< whom to tell, if that has not been done

    const boost::asio::any_io_executor executor_;
    const tcp::resolver::results_type endpoints_;
    tcp::resolver::results_type::const_iterator next_;
    std::list<tcp::socket> tries_; ///< under way
    boost::asio::steady_timer pause_, deadline_;
    boost::system::error_code why_; ///< the last one failed
    Done done_;                     ///< empty: it is over
};

} // namespace seaway::sockets
