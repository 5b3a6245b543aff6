// SPDX-License-Identifier: Apache-2.0
// Heads of requests: whatever stands in the fields, what is taken has a path, no other page's Origin and
// on its own machine a host that the server knows. Input: fields, each up to a line end.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/net/http_head.h"

using namespace seaway::server;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Origins origins = *Origins::read({"https://sea.example.org"}, "machine");
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    std::array<std::string_view, 7> fields{};
    for (std::string_view& field : fields) {
        const std::size_t end = rest.find('\n');
        field = rest.substr(0, end);
        rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    }
    HttpHead head{.method = "GET", .target = fields[0], .hosts = {fields[1]}};
    const auto also = [](std::string_view field, std::vector<std::string_view>& fields_of) {
        if (!field.empty())
            fields_of.push_back(field);
    };
    also(fields[2], head.origins);
    also(fields[3], head.transfer_encodings);
    also(fields[4], head.authorizations);
    head.fetch_site = fields[5];
    head.fetch_mode = fields[6];
    const bool tls = size % 2 == 1;
    const auto read = read_head(head, origins, true, tls);
    const auto elsewhere = read_head(head, origins, false, tls);
    if (std::holds_alternative<Asked>(read) && std::holds_alternative<Refused>(elsewhere))
        std::abort(); // this machine is not held to less
    if (const auto* asked = std::get_if<Asked>(&read)) {
        const auto host = read_authority(fields[1]);
        if (asked->path.empty() || !host)
            std::abort();
        if (fields[0].starts_with('/') && !origins.knows(*host))
            std::abort();
        if (fields[0].starts_with('/') && !fields[2].empty() &&
            !origins.allows(fields[2], *host, tls))
            std::abort();
    }
    (void)offers(fields[0], "seaway.v1");
    return 0;
}
