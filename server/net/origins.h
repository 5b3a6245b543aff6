// SPDX-License-Identifier: Apache-2.0
// Origins: which web pages may use the server, and under which names it answers. Values; thread-safe.
//
// A browser lets any page send requests to any server, with the user's place in the network; it says
// who asks in the field Origin (RFC 6454). A page whose name is made to point at this machine (DNS
// rebinding) is of the server's own origin for the browser: what gives it away is its name, in Host.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace seaway::server {

/// Host and port of a Host field or a URL (RFC 3986, section 3.2).
struct Authority {
    std::string host;     ///< lower case, without brackets and without a dot at its end
    int port = 0;         ///< 0: none was said
    bool literal = false; ///< an IP address, not a name

    /// Nobody else's server can have this name: an address, localhost or *.localhost (RFC 6761).
    bool is_certain() const;
};

/// Empty where the text is none: HOST, HOST:PORT, 1.2.3.4:PORT, [::1]:PORT.
std::optional<Authority> read_authority(std::string_view text);

class Origins {
  public:
    /// Each SCHEME://HOST[:PORT]. `null`, which any page can bring about, and * are errors.
    /// `own_host`: what this machine is called by itself; may be empty.
    static Result<Origins> read(const std::vector<std::string>& allowed,
                                const std::string& own_host = {});

    /// `origin` was allowed by name, or it is the server's own: same scheme, host and port as the
    /// request whose `host` this is, and a host that it knows.
    bool allows(std::string_view origin, const Authority& host, bool tls) const;
    /// The server may be called so: a host that is certain, allowed or the machine's own.
    bool knows(const Authority& host) const {
        return host.is_certain() || hosts_.count(host.host) > 0;
    }

  private:
    std::set<std::string> allowed_; ///< scheme://host:port
    std::set<std::string> hosts_;
};

} // namespace seaway::server
