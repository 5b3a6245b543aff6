// SPDX-License-Identifier: Apache-2.0
// Who the connections come from, address by address, and what each address has left of what one
// address may take. An IPv4 address stands for itself, an IPv6 address for its network of 64 bits: that is
// what one subscriber is given. Of the io thread alone; time is handed in.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/host/quality.h"
#include "server/net/endpoint.h"
#include "server/net/options.h"

namespace seaway::server {

/// An amount that is used up and comes back evenly: `burst` at most, `burst` again after `refill`.
/// A burst of 0 is no limit.
class Bucket {
  public:
    using Clock = std::chrono::steady_clock;

    Bucket(double burst, std::chrono::milliseconds refill)
        : burst_(burst), per_s_(burst / std::chrono::duration<double>(refill).count()),
          level_(burst) {}

    /// More than there is may be taken: the debt is waited for.
    void take(double amount, Clock::time_point now);
    /// Until there is so much; 0 if there is.
    std::chrono::milliseconds wait_for(double amount, Clock::time_point now);
    bool is_full(Clock::time_point now);

  private:
    void fill(Clock::time_point now);

    double burst_;
    double per_s_;
    double level_;
    Clock::time_point seen_{};
};

/// Why somebody is turned away for what his address does.
enum class Crowding { connections, sessions, wrong_tokens, tokens_not_looked_at, not_understood };
inline constexpr std::size_t crowdings = 5;

/// How many sessions of an address are sent each kind of coarser maps: asked by each of them when grants are renewed.
class CoarserMaps {
  public:
    /// Of one session, which had none or `was` and has none or `now`.
    void change(std::optional<Quality> was, std::optional<Quality> now);
    /// Kinds that sessions have beside one that has none or `own`.
    std::size_t kinds_but(std::optional<Quality> own) const;

  private:
    std::map<Quality, int> sessions_;
};

struct Address {
    Address(std::string who, const NetOptions& options);

    const std::string name; ///< "203.0.113.7", "2001:db8:1:2::/64"
    int connections = 0;
    int without_hello = 0; ///< sessions, and upgrades under way
    Bucket wrong_tokens;
    Bucket request_bytes;
    CoarserMaps coarser_maps;

    /// Counts one more that is turned away. The number since the last line of the log where a new
    /// line is due, else 0: the first at once, then one in `log_pause`.
    std::uint64_t turn_away(Crowding why, Bucket::Clock::time_point now);
    static constexpr std::chrono::seconds log_pause{10};

  private:
    struct Told {
        std::uint64_t since = 0;
        Bucket::Clock::time_point at{};
        bool ever = false;
    };
    std::array<Told, crowdings> told_;
};
using AddressPtr = std::shared_ptr<Address>;

/// What counts as one address: of "203.0.113.7" or "::ffff:203.0.113.7" that one, of an IPv6 address
/// the network of its first 64 bits.
std::string address_name(std::string_view ip);

class Addresses {
  public:
    explicit Addresses(const NetOptions& options) : options_(options) {}

    /// `ip` as text. Whoever has connections keeps the pointer; else an address is remembered until
    /// what it used has come back, or until there are too many of them.
    AddressPtr of(std::string_view ip, Bucket::Clock::time_point now);
    std::size_t size() const { return known_.size(); }
    static constexpr std::size_t remembered_max = 16384;

  private:
    void forget(Bucket::Clock::time_point now);

    const NetOptions& options_;
    std::map<std::string, AddressPtr, std::less<>> known_;
    std::size_t forget_at_ = 1024;
};

/// Who is at the other end of a connection.
struct Peer {
    std::string name; ///< for the log: "127.0.0.1:4711"
    AddressPtr address;
    bool loopback = false; ///< on this machine
    bool tls = false;

    /// What it says has been seen by nobody on the way.
    bool unseen() const { return tls || loopback; }
};

/// On this machine are 127.0.0.0/8, ::1, and what a listener of both kinds calls the former: "::ffff:127.0.0.1".
Peer peer_of(const Endpoint& from, AddressPtr address, bool tls);

/// One more of a count of its address, for as long as it lives.
template <int Address::*count>
class Counted {
  public:
    explicit Counted(AddressPtr address) : address_(std::move(address)) { ++((*address_).*count); }
    ~Counted() {
        if (address_ != nullptr)
            --((*address_).*count);
    }
    Counted(Counted&& other) noexcept : address_(std::move(other.address_)) {}
    Counted& operator=(Counted&&) = delete;
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

  private:
    AddressPtr address_;
};

} // namespace seaway::server
