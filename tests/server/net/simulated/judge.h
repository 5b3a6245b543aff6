// SPDX-License-Identifier: Apache-2.0
// Judge: hears of everything that happens in a simulated crowd, and keeps the first thing that must not
// happen, with what came before it.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include <fmt/format.h>

namespace seaway::tests::simulated {

class Judge {
  public:
    /// One line of the story; the last ones are kept.
    void tell(std::string event) {
        events_.push_back(std::move(event));
        if (events_.size() > events_kept)
            events_.pop_front();
    }
    /// The first broken promise is the verdict.
    void require(bool kept, const std::string& promise) {
        if (!kept && verdict_.empty())
            verdict_ = promise;
    }
    /// How often something was seen: a simulation in which nothing happens shows nothing.
    void count(const std::string& what) { ++seen_[what]; }

    bool broken() const { return !verdict_.empty(); }
    const std::map<std::string, std::uint64_t>& seen() const { return seen_; }
    std::string story() const {
        std::string text;
        for (const std::string& event : events_)
            text += "    " + event + "\n";
        return text + "  " + verdict_;
    }

    /// Of every byte that was sent, in order.
    void digest(const std::uint8_t* bytes, std::size_t size) {
        for (std::size_t i = 0; i < size; ++i)
            digest_ = (digest_ ^ bytes[i]) * 0x100000001b3u;
    }
    std::uint64_t digest() const { return digest_; }

  private:
    static constexpr std::size_t events_kept = 40;
    std::deque<std::string> events_;
    std::string verdict_;
    std::map<std::string, std::uint64_t> seen_;
    std::uint64_t digest_ = 0xcbf29ce484222325u;
};

} // namespace seaway::tests::simulated
