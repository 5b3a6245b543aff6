// SPDX-License-Identifier: Apache-2.0
#include "server/journal/nats_peers.h"

#include <chrono>
#include <new>
#include <utility>

#include <nats/nats.h>

#include "base/thread_name.h"
#include "server/journal/peer_clocks.h"

namespace seaway::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::microseconds every{PeerClocks::every_us};
/// It looks so often whether it is to stop.
constexpr int nap_ms = 100;

struct DestroySubscription {
    void operator()(natsSubscription* subscription) const {
        natsSubscription_Destroy(subscription);
    }
};
struct DestroyMessage {
    void operator()(natsMsg* message) const { natsMsg_Destroy(message); }
};

} // namespace

NatsPeers::NatsPeers(NatsConnection connection)
    : connection_(std::move(connection)),
      subject_("seaway." + connection_.place().world + ".clock") {}

NatsPeers::~NatsPeers() {
    stopping_ = true;
    connection_.connect_no_more();
    if (thread_.joinable())
        thread_.join();
}

void NatsPeers::begin(std::function<std::string()> say,
                      std::function<void(const std::string&)> hear) {
    say_ = std::move(say);
    hear_ = std::move(hear);
    thread_ = std::thread([this] { run(); });
}

void NatsPeers::run() {
    name_thread("sea-peers");
    while (!stopping_) {
        try {
            exchange();
        } catch (const std::bad_alloc&) { // others miss a word
        }
        if (!stopping_)
            std::this_thread::sleep_for(std::chrono::milliseconds(nap_ms));
    }
}

void NatsPeers::exchange() {
    const Result<natsConnection*> connection = connection_.get();
    natsSubscription* made = nullptr;
    if (!connection ||
        natsConnection_SubscribeSync(&made, *connection, subject_.c_str()) != NATS_OK)
        return connection_.drop();
    const std::unique_ptr<natsSubscription, DestroySubscription> subscription(made);
    for (Clock::time_point next = Clock::now(); !stopping_;) {
        natsStatus status = NATS_OK;
        if (Clock::now() >= next) {
            next = Clock::now() + every;
            const std::string word = say_();
            status = natsConnection_Publish(*connection, subject_.c_str(), word.data(),
                                            static_cast<int>(word.size()));
            if (status == NATS_OK)
                status = natsConnection_FlushTimeout(*connection, nats_patience_ms);
        }
        natsMsg* heard = nullptr;
        if (status == NATS_OK)
            status = natsSubscription_NextMsg(&heard, made, nap_ms);
        const std::unique_ptr<natsMsg, DestroyMessage> message(heard);
        if (status == NATS_OK)
            hear_({natsMsg_GetData(heard), static_cast<std::size_t>(natsMsg_GetDataLength(heard))});
        else if (status != NATS_TIMEOUT)
            break;
    }
    // Before its connection is closed.
    natsSubscription_Unsubscribe(made);
    connection_.drop();
}

} // namespace seaway::server
