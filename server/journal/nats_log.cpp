// SPDX-License-Identifier: Apache-2.0
#include "server/journal/nats_log.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nats/nats.h>

namespace seaway::server {
namespace {

template <class T, void (*destroy)(T*)>
struct Destroy {
    void operator()(T* what) const { destroy(what); }
};
using Context = std::unique_ptr<jsCtx, Destroy<jsCtx, jsCtx_Destroy>>;
using Message = std::unique_ptr<natsMsg, Destroy<natsMsg, natsMsg_Destroy>>;
using Info = std::unique_ptr<jsStreamInfo, Destroy<jsStreamInfo, jsStreamInfo_Destroy>>;
using Acknowledgement = std::unique_ptr<jsPubAck, Destroy<jsPubAck, jsPubAck_Destroy>>;
using Subscription =
    std::unique_ptr<natsSubscription, Destroy<natsSubscription, natsSubscription_Destroy>>;

/// Messages that are asked for and have not come: as many as weigh so much, by those that have; NATS cuts off who has 64 MB to come.
constexpr std::uint64_t reads_under_way_max = 256, reads_under_way_min = 8;
constexpr std::uint64_t bytes_under_way = 16 << 20;
/// Before those that have not come are asked for again.
constexpr int silence_ms = 100;

/// Of a message that was read; 0: it is none.
std::uint64_t number_of(natsMsg* message) {
    const char* text = nullptr;
    if (natsMsgHeader_Get(message, "Nats-Sequence", &text) != NATS_OK)
        return 0;
    return std::strtoull(text, nullptr, 10);
}

/// Of "2026-11-24T12:51:10.123456789Z"; 0 where there is none.
std::int64_t stored_utc_us(natsMsg* message) {
    const char* text = nullptr;
    int year = 0;
    unsigned month = 0, day = 0, hour = 0, minute = 0;
    double second = 0;
    if (natsMsgHeader_Get(message, "Nats-Time-Stamp", &text) != NATS_OK ||
        std::sscanf(text, "%d-%u-%uT%u:%u:%lfZ", &year, &month, &day, &hour, &minute, &second) != 6)
        return 0;
    using namespace std::chrono;
    const sys_days date(std::chrono::year(year) / static_cast<int>(month) / static_cast<int>(day));
    return duration_cast<microseconds>(date.time_since_epoch() + hours(hour) + minutes(minute))
               .count() +
           std::llround(1e6 * second);
}

/// That it was written under; empty: under none.
std::string id_of(natsMsg* message) {
    const char* text = nullptr;
    return natsMsgHeader_Get(message, "Nats-Msg-Id", &text) == NATS_OK ? text : "";
}

/// What the engine has said, in its own words where it has some.
std::string said(natsStatus status, int code) {
    // Also in the moment in which it starts, or makes a stream: the library says of no responders that there is no JetStream.
    if (status == NATS_NO_RESPONDERS || code == JSNotEnabledErr ||
        code == JSNotEnabledForAccountErr)
        return "nobody there keeps logs: NATS runs without JetStream, or does not have it yet";
    const char* last = nats_GetLastError(nullptr);
    if (code == 0 || !last)
        return natsStatus_GetText(status);
    const std::string words =
        last; // "(jsm.c:1033): stream is offline": the place is one of the library
    const std::size_t end = words.starts_with('(') ? words.find("): ") : std::string::npos;
    return end == std::string::npos ? words : words.substr(end + 3);
}

/// The engine has answered, and that is its answer. All else is the network's, or passes.
bool is_final(natsStatus status, int code) {
    constexpr int first = 10000; // errors of JetStream begin here; a cluster has some that pass
    switch (code) {
    case JSNotEnabledErr:
    case JSNotEnabledForAccountErr:
    case JSClusterIncompleteErr:
    case JSClusterNotActiveErr:
    case JSClusterNotAssignedErr:
    case JSStreamOfflineErr:
    case JSClusterNoPeersErr:
    case JSClusterNotAvailErr:
    case JSClusterNotLeaderErr:
    case JSInsufficientResourcesErr:
    case JSTempStorageFailedErr:
    case JSStreamStoreFailedErr:
        return false;
    default:
        return code > first || status == NATS_MAX_PAYLOAD || status == NATS_NOT_PERMITTED;
    }
}

/// A stream that keeps everything it was given, in files; else what it does.
std::string fault_of(const jsStreamConfig& config, const std::string& subject) {
    if (config.SubjectsLen != 1 || config.Subjects[0] != subject)
        return fmt::format("takes other subjects than {}", subject);
    if (config.Storage != js_FileStorage)
        return "is kept in memory";
    if (config.Retention != js_LimitsPolicy || config.MaxAge > 0 || config.MaxMsgs > 0 ||
        config.MaxBytes > 0 || config.MaxMsgsPerSubject > 0)
        return "has a limit beyond which it forgets";
    if (!config.AllowDirect)
        return "does not allow direct reads (allow_direct)";
    return config.Mirror ? "is a mirror" : "";
}

/// For how long who leads a stream has not heard of one more node of those that make a majority with it: since then others
/// may have chosen another. 0 without a cluster; none: nobody leads.
std::optional<std::int64_t> majority_heard_us(const jsClusterInfo* cluster) {
    if (cluster == nullptr || cluster->ReplicasLen == 0)
        return 0;
    if (cluster->Leader == nullptr || *cluster->Leader == '\0')
        return std::nullopt;
    std::vector<std::int64_t> silent_us;
    for (int i = 0; i < cluster->ReplicasLen; ++i)
        silent_us.push_back(cluster->Replicas[i]->Active / 1000);
    std::ranges::sort(silent_us);
    return silent_us[(silent_us.size() + 1) / 2 - 1];
}

Result<Context> context_of(natsConnection* connection) {
    jsOptions options;
    jsOptions_Init(&options);
    options.Wait = nats_patience_ms;
    jsCtx* made = nullptr;
    const natsStatus status = natsConnection_JetStream(&made, connection, &options);
    if (status != NATS_OK)
        return Error{LogFailure::unreachable, said(status, 0)};
    return Context(made);
}

bool is_there(jsCtx* context, const std::string& stream) {
    jsStreamInfo* found = nullptr;
    const natsStatus status = js_GetStreamInfo(&found, context, stream.c_str(), nullptr, nullptr);
    const Info info(found);
    return status == NATS_OK;
}

} // namespace

NatsLog::NatsLog(NatsConnection connection)
    : connection_(std::move(connection)), stream_("SEAWAY_" + connection_.place().world),
      subject_("seaway." + connection_.place().world + ".log") {}

Error NatsLog::unanswered(natsConnection* connection, ErrorKind kind, const std::string& why) {
    const char* aside = nullptr;
    const bool forbidden =
        natsConnection_GetLastError(connection, &aside) == NATS_NOT_PERMITTED && aside;
    const std::string said_aside = forbidden ? aside : "";
    connection_.drop();
    if (!forbidden)
        return Error{kind, why};
    return Error{fmt::format(
        "NATS does not let this user do what the log needs ({0}). Needed are: publish "
        "$JS.API.STREAM.INFO.{1}, $JS.API.STREAM.CREATE.{1}, $JS.API.DIRECT.GET.{1}, seaway.{2}.*; "
        "subscribe _INBOX.>, seaway.{2}.clock",
        said_aside, stream_, connection_.place().world)};
}

Result<void> NatsLog::make_stream() {
    SEAWAY_TRY_LET(natsConnection * connection, connection_.get());
    SEAWAY_TRY_LET(const Context context, context_of(connection));
    jsStreamConfig config;
    jsStreamConfig_Init(&config);
    const char* subjects[] = {subject_.c_str()};
    config.Name = stream_.c_str();
    config.Description = "Changes of a sea, seaway-server --journal";
    config.Subjects = subjects;
    config.SubjectsLen = 1;
    config.Storage = js_FileStorage;
    config.Retention = js_LimitsPolicy;
    config.Discard = js_DiscardNew;
    config.Replicas = connection_.place().replicas;
    config.DenyDelete = true;
    config.DenyPurge = true;
    config.AllowDirect = true;
    jsErrCode code = {};
    const natsStatus status = js_AddStream(nullptr, context.get(), &config, nullptr, &code);
    const std::string why = said(status, code);
    // Of several who make it at once the others find it there, by its name or, in the moment in which it is made, by its
    // subject alone: which another's stream may have, too.
    if (status == NATS_OK || code == JSStreamNameExistErr ||
        (code == JSStreamSubjectOverlapErr && is_there(context.get(), stream_)))
        return {};
    if (is_final(status, code))
        return Error{fmt::format("stream {} cannot be made: {}", stream_, why)};
    return unanswered(connection, LogFailure::unreachable, why);
}

Result<SharedLog::Tail> NatsLog::tail() {
    for (bool made = false;; made = true) {
        SEAWAY_TRY_LET(natsConnection * connection, connection_.get());
        SEAWAY_TRY_LET(const Context context, context_of(connection));
        jsStreamInfo* found = nullptr;
        jsErrCode code = {};
        const natsStatus status =
            js_GetStreamInfo(&found, context.get(), stream_.c_str(), nullptr, &code);
        const Info info(found);
        if (status == NATS_OK) {
            if (const std::string fault = fault_of(*info->Config, subject_); !fault.empty())
                return Error{
                    fmt::format("stream {} {}: it cannot hold the log of a sea; it is left as it "
                                "is",
                                stream_, fault)};
            if (info->State.Msgs != info->State.LastSeq && info->State.FirstSeq <= 1)
                return Error{fmt::format("stream {} holds {} of {} messages: others were deleted",
                                         stream_, info->State.Msgs, info->State.LastSeq)};
            if (info->State.LastSeq > 0 && info->State.FirstSeq != 1)
                return Error{fmt::format("stream {} begins at message {}: what was before is lost",
                                         stream_, info->State.FirstSeq)};
            may_make_ = false;
            const std::optional<std::int64_t> unsure_us = majority_heard_us(info->Cluster);
            if (!unsure_us)
                return Error{LogFailure::unanswered,
                             fmt::format("stream {} has nobody who leads it now", stream_)};
            return Tail{info->State.LastSeq, std::to_string(info->Created),
                        info->State.LastTime / 1000, *unsure_us};
        }
        if (status == NATS_NOT_FOUND && !made && may_make_) {
            SEAWAY_TRY(make_stream());
            continue;
        }
        const std::string why = said(status, code);
        if (status == NATS_NOT_FOUND)
            return Error{fmt::format("stream {} is not there any more", stream_)};
        if (is_final(status, code))
            return Error{fmt::format("stream {}: {}", stream_, why)};
        return unanswered(connection, LogFailure::unanswered, "NATS does not answer: " + why);
    }
}

/// Asks for a window of messages and takes what comes, each on its own: in no order, as copies of the stream share the questions. One
/// that is behind does not have a message, and one that is cut off keeps its share to itself: what does not come is asked for again.
Result<std::vector<SharedLog::Stored>> NatsLog::read(std::uint64_t first, std::uint64_t last) {
    SEAWAY_TRY_LET(natsConnection * connection, connection_.get());
    const std::string get = "$JS.API.DIRECT.GET." + stream_;
    char* made = nullptr;
    natsStatus status = natsInbox_Create(&made);
    const std::unique_ptr<char, Destroy<natsInbox, natsInbox_Destroy>> inbox(made);
    natsSubscription* subscribed = nullptr;
    if (status == NATS_OK)
        status = natsConnection_SubscribeSync(&subscribed, connection, made);
    const Subscription subscription(subscribed);
    const auto ask = [&](std::uint64_t number) {
        return natsConnection_PublishRequestString(connection, get.c_str(), made,
                                                   fmt::format("{{\"seq\":{}}}", number).c_str());
    };
    std::vector<std::optional<Stored>> messages(last - first + 1);
    std::uint64_t asked = 0, come = 0, reads_under_way = reads_under_way_min, largest = 1;
    for (int silences = 0; status == NATS_OK && come < messages.size();) {
        for (; status == NATS_OK && asked < messages.size() && asked - come < reads_under_way;
             ++asked)
            status = ask(first + asked);
        natsMsg* next = nullptr;
        if (status == NATS_OK)
            status = natsSubscription_NextMsg(&next, subscription.get(), silence_ms);
        const Message message(next);
        if (status == NATS_TIMEOUT && ++silences < nats_patience_ms / silence_ms) {
            status = NATS_OK;
            for (std::uint64_t i = 0; status == NATS_OK && i < asked; ++i)
                status = messages[i] ? NATS_OK : ask(first + i);
        }
        const std::uint64_t number = status == NATS_OK && next ? number_of(next) : 0;
        if (number < first || number > last || messages[number - first])
            continue;
        const auto bytes = static_cast<std::size_t>(natsMsg_GetDataLength(next));
        messages[number - first] =
            Stored{std::string(natsMsg_GetData(next), bytes), stored_utc_us(next), id_of(next)};
        ++come;
        largest = std::max<std::uint64_t>(largest, bytes);
        reads_under_way =
            std::clamp(bytes_under_way / largest, reads_under_way_min, reads_under_way_max);
        silences = 0;
    }
    if (status != NATS_OK)
        return unanswered(connection, LogFailure::unanswered,
                          fmt::format("NATS does not give messages {} to {}: {}", first, last,
                                      natsStatus_GetText(status)));
    std::vector<Stored> all;
    for (std::optional<Stored>& one : messages)
        all.push_back(*std::move(one));
    return all;
}

Result<std::uint64_t> NatsLog::write(const std::string& message, const std::string& id,
                                     std::uint64_t expected_last) {
    SEAWAY_TRY_LET(natsConnection * connection, connection_.get());
    SEAWAY_TRY_LET(const Context context, context_of(connection));
    jsPubOptions options;
    jsPubOptions_Init(&options);
    options.MaxWait = nats_patience_ms;
    options.MsgId = id.c_str();
    options.ExpectStream = stream_.c_str();
    // Of the stream, not of its one subject, though both are the same number: in a cluster who leads compares that of the subject
    // with what it has stored, before the others have agreed to what is under way, and takes each of several.
    options.ExpectLastSeq = expected_last;
    options.ExpectNoMessage = expected_last == 0;
    jsPubAck* acknowledged = nullptr;
    jsErrCode code = {};
    const natsStatus status =
        js_Publish(&acknowledged, context.get(), subject_.c_str(), message.data(),
                   static_cast<int>(message.size()), &options, &code);
    const Acknowledgement acknowledgement(acknowledged);
    if (status == NATS_OK)
        return acknowledgement->Sequence;
    if (code == JSStreamWrongLastSequenceErr)
        return Error{LogFailure::outrun, "another change was appended first"};
    if (status == NATS_MAX_PAYLOAD)
        return Error{fmt::format("the change has {} bytes, and NATS takes {} (max_payload)",
                                 message.size(), natsConnection_GetMaxPayload(connection))};
    const std::string why = said(status, code);
    if (is_final(status, code))
        return Error{why};
    return unanswered(connection, LogFailure::unanswered, "NATS does not answer: " + why);
}

} // namespace seaway::server
