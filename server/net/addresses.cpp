// SPDX-License-Identifier: Apache-2.0
#include "server/net/addresses.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/network_v6.hpp>

namespace seaway::server {

namespace ip = boost::asio::ip;

void Bucket::fill(Clock::time_point now) {
    if (now > seen_) {
        const std::chrono::duration<double> passed = now - std::exchange(seen_, now);
        level_ = std::min(burst_, level_ + per_s_ * passed.count());
    }
}

void Bucket::take(double amount, Clock::time_point now) {
    fill(now);
    if (burst_ > 0)
        level_ -= amount;
}

std::chrono::milliseconds Bucket::wait_for(double amount, Clock::time_point now) {
    fill(now);
    if (burst_ <= 0 || level_ >= amount)
        return std::chrono::milliseconds(0);
    constexpr double rounding_ms = 1e-3;
    return std::chrono::milliseconds(
        static_cast<std::int64_t>(std::ceil(1000.0 * (amount - level_) / per_s_ - rounding_ms)));
}

bool Bucket::is_full(Clock::time_point now) {
    fill(now);
    return level_ >= burst_;
}

void CoarserMaps::change(std::optional<Quality> was, std::optional<Quality> now) {
    if (now == was)
        return;
    if (now)
        ++sessions_[*now];
    if (was && --sessions_.at(*was) == 0)
        sessions_.erase(*was);
}

std::size_t CoarserMaps::kinds_but(std::optional<Quality> own) const {
    return sessions_.size() - (own && sessions_.at(*own) == 1 ? 1 : 0);
}

Address::Address(std::string who, const NetOptions& options)
    : name(std::move(who)),
      wrong_tokens(options.wrong_tokens_per_address, options.wrong_tokens_refill),
      request_bytes(2 * options.request_bytes_per_s_per_address, std::chrono::seconds(2)) {}

std::uint64_t Address::turn_away(Crowding why, Bucket::Clock::time_point now) {
    Told& told = told_[static_cast<std::size_t>(why)];
    ++told.since;
    if (told.ever && now - told.at < log_pause)
        return 0;
    told.ever = true;
    told.at = now;
    return std::exchange(told.since, 0);
}

namespace {

/// Of "::ffff:203.0.113.7" the IPv4 address. No address: of what is none.
std::optional<ip::address> read_address(std::string_view text) {
    boost::system::error_code error;
    const ip::address address = ip::make_address(std::string(text), error);
    if (error)
        return std::nullopt;
    if (address.is_v6() && address.to_v6().is_v4_mapped())
        return ip::make_address_v4(ip::v4_mapped, address.to_v6());
    return address;
}

} // namespace

std::string address_name(std::string_view text) {
    const std::optional<ip::address> address = read_address(text);
    if (!address)
        return std::string(text);
    if (address->is_v4())
        return address->to_string();
    return ip::make_network_v6(ip::address_v6(address->to_v6().to_bytes()), 64)
        .canonical()
        .to_string();
}

Peer peer_of(const Endpoint& from, AddressPtr address, bool tls) {
    const std::optional<ip::address> ip = read_address(from.ip);
    return {from.text(), std::move(address), ip && ip->is_loopback(), tls};
}

AddressPtr Addresses::of(std::string_view ip, Bucket::Clock::time_point now) {
    const std::string name = address_name(ip);
    if (const auto found = known_.find(name); found != known_.end())
        return found->second;
    if (known_.size() >= forget_at_)
        forget(now);
    return known_.emplace(name, std::make_shared<Address>(name, options_)).first->second;
}

void Addresses::forget(Bucket::Clock::time_point now) {
    const auto unused = [](const auto& known) { return known.second.use_count() == 1; };
    std::erase_if(known_, [&](const auto& known) {
        return unused(known) && known.second->wrong_tokens.is_full(now) &&
               known.second->request_bytes.is_full(now);
    });
    if (known_.size() >= remembered_max)
        std::erase_if(known_, unused);
    forget_at_ = std::clamp(2 * known_.size(), std::size_t{1024}, remembered_max);
    forget_at_ = std::max(forget_at_, known_.size() + 1);
}

} // namespace seaway::server
