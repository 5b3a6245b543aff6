// SPDX-License-Identifier: Apache-2.0
// PeerLine: carries words between the servers of one log, now and then and as fast as it can. What is lost is lost.
#pragma once

#include <functional>
#include <string>

namespace seaway::server {

class PeerLine {
  public:
    virtual ~PeerLine() = default; ///< from then on nothing is called

    /// From now on, on a thread of its own: what say() gives goes to all others once a second, what they say to hear().
    virtual void begin(std::function<std::string()> say,
                       std::function<void(const std::string&)> hear) = 0;
};

} // namespace seaway::server
