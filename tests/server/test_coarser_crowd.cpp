// SPDX-License-Identifier: Apache-2.0
// A real server, sessions of one address that want odd maps, and a neighbour on a thin line.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/net/clients.h"
#include "tests/support/server_process.h"

namespace seaway {
namespace {

using wire::Body;

/// A session that has asked for heights of maps of at most such a size.
class Asker {
  public:
    Asker(int port, int size_max, bool compact, const std::string& from = "127.0.0.1")
        : client_(port, from) {
        EXPECT_FALSE(client_.connect());
        EXPECT_TRUE(client_.greet());
        EXPECT_FALSE(client_.send(protocol::subscribe(
            1, {.fields = {sea::Field::height}, .compact = compact, .size_max = size_max}, 8)));
    }
    /// Of the next grant; 0: any. Nothing within a minute: -1.
    int granted_size() {
        const wire::Message* message = client_.receive(Body::Subscribed);
        if (message == nullptr)
            return -1;
        const wire::Subscribed& grant = *message->body_as_Subscribed();
        why_ = grant.why() != nullptr ? grant.why()->str() : "";
        return grant.limits() != nullptr ? static_cast<int>(grant.limits()->size()) : 0;
    }
    const std::string& why() const { return why_; }

  private:
    tests::Client client_;
    std::string why_;
};

// Naive: eight kinds are all there are, and who asked first has them for as long as it stays: the others get maps a quarter as fine, or
// none, and keep those when it has gone.
TEST(CoarserCrowd, an_address_has_half_of_the_kinds_and_what_becomes_free_is_given_to_who_waits) {
    tests::ServerProcess server(
        {"scenes/north_sea_gale.toml", "--device", "native", "--listen", "127.0.0.1:0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    const int port = tests::port_of(url);
    std::vector<std::unique_ptr<Asker>> first;
    for (const auto& [size, compact] :
         {std::pair(32, false), {64, false}, {32, true}, {64, true}}) {
        first.push_back(std::make_unique<Asker>(port, size, compact));
        EXPECT_EQ(first.back()->granted_size(), size);
    }
    Asker late(port, 128, false);
    EXPECT_EQ(late.granted_size(), 64) << late.why();
    EXPECT_NE(late.why().find("of this address"), std::string::npos) << late.why();
    Asker neighbour(port, 128, true, "127.0.0.2");
    EXPECT_EQ(neighbour.granted_size(), 128) << neighbour.why();
    Asker shares(port, 32, false,
                 "127.0.0.2"); // what becomes free of one address is another's still
    EXPECT_EQ(shares.granted_size(), 32) << shares.why();
    first.erase(first.begin());
    EXPECT_EQ(late.granted_size(), 128) << late.why();
}

TEST(CoarserCrowd, behind_a_proxy_all_kinds_are_there_for_its_one_address) {
    tests::ServerProcess server({"scenes/north_sea_gale.toml", "--device", "native", "--listen",
                                 "127.0.0.1:0", "--connections-per-address", "0"});
    const std::string url = server.wait_until_ready();
    ASSERT_FALSE(url.empty()) << server.log();
    std::vector<std::unique_ptr<Asker>> all;
    for (const bool compact : {false, true})
        for (const int size : {32, 64, 128}) {
            all.push_back(std::make_unique<Asker>(tests::port_of(url), size, compact));
            EXPECT_EQ(all.back()->granted_size(), size) << all.back()->why();
        }
}

} // namespace
} // namespace seaway
