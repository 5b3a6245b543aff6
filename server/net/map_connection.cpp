// SPDX-License-Identifier: Apache-2.0
// A bulk map on its way: a length, then chunks as they are made and taken. It ends its connection.
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include "server/net/connection.h"
#include "server/net/http_response.h"
#include "server/net/refusals.h"
#include "sockets/socket.h"

namespace seaway::server {
namespace {

namespace asio = boost::asio;
using sockets::error_code;

/// Of who is being sent a map.
constexpr std::size_t unasked_bytes_max = 64 * 1024;

class MapConnection final : public MapReader, public std::enable_shared_from_this<MapConnection> {
  public:
    MapConnection(ConnectionSlot slot, sockets::Socket socket, Peer peer)
        : slot_(std::move(slot)), socket_(std::move(socket)), peer_(std::move(peer)),
          line_timer_(socket_.get_executor()) {}

    void run(std::map<std::string, std::string> parameters) {
        or_end([&] {
            socket_.expires_never(); // the host answers; what it takes is bounded there
            watch_peer();
            ask(std::move(parameters));
        });
    }

    // ---- MapReader -------------------------------------------------------------------------

    std::chrono::duration<double> behind() const override {
        const Clock::duration now =
            map_writing_ ? Clock::now() - map_write_begun_ : Clock::duration(0);
        const NetOptions& options = slot_.core()->options;
        const std::chrono::duration<double> earned(static_cast<double>(map_sent_) /
                                                   options.map_bytes_per_s_wanted);
        return map_waited_ + now - earned - options.map_patience;
    }

    void give_way() override { end_map(); }

  private:
    using Clock = std::chrono::steady_clock;

    Core& core() { return *slot_.core(); }

    /// A map for whose next step there is no memory is over.
    template <class Work>
    void or_end(Work work) {
        try {
            work();
        } catch (const std::bad_alloc&) {
            end_map();
            throw;
        }
    }
    /// What follows a step of the socket. The map is over, too, where nothing does: of a write in many parts one may find no memory.
    template <class Next>
    auto then(Next next) {
        struct Step {
            explicit Step(std::shared_ptr<MapConnection> of) : self(std::move(of)) {}
            ~Step() {
                if (!came)
                    self->end_map();
            }
            const std::shared_ptr<MapConnection> self;
            bool came = false;
        };
        return [step = std::make_shared<Step>(shared_from_this()),
                next = std::move(next)](error_code error, std::size_t bytes = 0) {
            step->came = true;
            step->self->or_end([&] { next(error, bytes); });
        };
    }

    void ask(std::map<std::string, std::string> parameters) {
        const bool may_come = core().map_places.ask(
            peer_.address,
            [weak = weak_from_this(), parameters = std::move(parameters)](MapPlaces::Place place) {
                if (const auto self = weak.lock(); self != nullptr && self->here_ != nullptr)
                    self->or_end([&] { self->start(parameters, std::move(place)); });
            },
            [weak = weak_from_this()] {
                const auto self = weak.lock();
                return self != nullptr && self->here_ != nullptr;
            });
        if (!may_come)
            respond({.status = 503,
                     .body = "as many maps are being made as there are places, try again later\n",
                     .retry_after_s = 1});
        else if (place_ == nullptr) {
            core().waiting_for_maps.insert(shared_from_this());
            wait_in_line();
        }
    }

    void wait_in_line() {
        line_timer_.expires_after(std::chrono::seconds(1));
        line_timer_.async_wait([weak = weak_from_this()](error_code gone) {
            const auto self = weak.lock();
            if (gone || self == nullptr || self->here_ == nullptr || self->place_ != nullptr)
                return;
            self->or_end([&] { self->wait_in_line(); });
            self->core().map_places.look_again(); // somebody else may find no memory in it
        });
    }

    void start(std::map<std::string, std::string> parameters, MapPlaces::Place place) {
        place_ = std::move(place);
        const std::weak_ptr<MapConnection> weak = weak_from_this();
        const auto core_ptr = slot_.core();
        const auto more_rows = [weak, core_ptr] {
            core_ptr->post([weak] {
                if (const auto self = weak.lock())
                    self->or_end([&] { self->write_map(); });
            });
        };
        core().waiting_for_maps.insert(shared_from_this());
        core().host.map({std::move(parameters), Asker(here_), more_rows},
                        [weak, core_ptr](Result<std::unique_ptr<ByteSource>> made) {
                            auto shared = std::make_shared<decltype(made)>(std::move(made));
                            core_ptr->post([weak, core_ptr, shared] {
                                if (const auto self = weak.lock())
                                    self->or_end([&] { self->begin_map(*shared); });
                                else
                                    core_ptr->disposal.take(shared);
                            });
                        });
    }

    /// A pending read notices that the peer has left, also while nothing is written to it. What it
    /// says meanwhile is not looked at: a map ends its connection, and so does who says too much.
    void watch_peer() {
        socket_.async_read_some(asio::buffer(unasked_),
                                then([this](error_code error, std::size_t bytes) {
                                    if (here_ == nullptr)
                                        return;
                                    unasked_bytes_ += bytes;
                                    if (!error && unasked_bytes_ <= unasked_bytes_max)
                                        return watch_peer();
                                    end_map();
                                }));
    }

    void begin_map(Result<std::unique_ptr<ByteSource>>& made) {
        if (!made) {
            if (here_ == nullptr)
                return end_map();
            return respond({.status = http_status(made.error()),
                            .body = made.error().message + "\n",
                            .retry_after_s = retry_after_s(made.error())});
        }
        map_ = *std::move(made);
        if (here_ == nullptr)
            return end_map();
        begin_map_write();
        write_map_header(core(), socket_, map_->size(), then([this](error_code error, std::size_t) {
                             core().map_places.reads(weak_from_this());
                             on_map_written(error);
                         }));
    }

    /// Why there is no map.
    void respond(const Page& page) {
        core().waiting_for_maps.erase(shared_from_this());
        here_ = nullptr;
        place_ = nullptr;
        write_page(core(), socket_, page, false, false, then([this](error_code error, std::size_t) {
                       error ? failed(error) : close();
                   }));
    }

    void write_map() {
        if (!map_ || map_writing_)
            return;
        map_chunk_ = map_->next();
        if (map_chunk_.empty()) {
            if (map_sent_ == map_->size() || map_->failed())
                return end_map();
            return socket_.expires_never(); // waits for the next chunk, not for the peer
        }
        begin_map_write();
        asio::async_write(socket_, asio::buffer(map_chunk_),
                          then([this](error_code error, std::size_t) {
                              map_sent_ += map_chunk_.size();
                              on_map_written(error);
                          }));
    }

    /// The peer has write_timeout for each piece, and for all that it is behind the least rate.
    void begin_map_write() {
        map_writing_ = true;
        map_write_begun_ = Clock::now();
        const std::chrono::duration<double> earned(
            static_cast<double>(map_sent_ + map_chunk_.size()) /
            core().options.map_bytes_per_s_min);
        const auto left = core().options.write_timeout - map_waited_ + earned;
        socket_.expires_after(
            std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(left),
                       std::chrono::milliseconds(1), core().options.write_timeout));
    }

    void on_map_written(error_code error) {
        map_writing_ = false;
        map_waited_ += Clock::now() - map_write_begun_;
        if (error) {
            end_map();
            return failed(error);
        }
        write_map();
    }

    /// Takes no memory.
    void end_map() noexcept {
        const auto self = shared_from_this();
        core().waiting_for_maps.erase(self);
        here_ = nullptr;
        if (map_ && place_ != nullptr)
            core().map_places.ends(place_);
        if (map_) { // its threads end in their own time, and its place comes back when they have
            *std::exchange(made_, nullptr) = Made(std::move(place_), std::move(map_));
            core().disposal.take(std::move(ends_));
        }
        place_ = nullptr;
        close();
    }

    void failed(error_code error) {
        socket_.close();
        if (!is_usual_end(error))
            note_bad_peer(core(), peer_, "http", error.message());
    }

    void close() {
        socket_.shutdown_send();
        socket_.close();
    }

    ConnectionSlot slot_;
    sockets::Socket socket_;
    Peer peer_;
    asio::steady_timer line_timer_;
    MapPlaces::Place place_;

    std::shared_ptr<const void> here_ =
        std::make_shared<char>(); ///< until no map is wanted any more
    std::array<std::uint8_t, 512> unasked_{};
    std::size_t unasked_bytes_ = 0; ///< in all
    std::unique_ptr<ByteSource> map_;
    using Made = std::pair<MapPlaces::Place, std::unique_ptr<ByteSource>>;
    std::shared_ptr<Made> made_ = std::make_shared<Made>(); ///< what ends_ lets go of
    Disposal::Things ends_{made_};
    std::vector<std::uint8_t> map_chunk_; ///< being written
    std::uint64_t map_sent_ = 0;
    bool map_writing_ = false;
    Clock::time_point map_write_begun_;
    Clock::duration map_waited_{0}; ///< for the peer, all in all
};

} // namespace

void serve_map(ConnectionSlot slot, sockets::Socket socket, Peer peer,
               std::map<std::string, std::string> parameters) {
    std::make_shared<MapConnection>(std::move(slot), std::move(socket), std::move(peer))
        ->run(std::move(parameters));
}

} // namespace seaway::server
