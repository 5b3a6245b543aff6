// SPDX-License-Identifier: Apache-2.0
// Session: the waves themselves. They are made on a thread of their own (Core::spectra), once a rung, and sent
// message by message as the client takes them.
#include <algorithm>
#include <chrono>
#include <new>

#include "protocol/limits.h"
#include "server/host/refusal.h"
#include "server/net/session.h"
#include "server/net/session_behind.h"

namespace seaway::server {

namespace limits = protocol::limits;
using wire::ErrorCode;

namespace {

/// Waves that are owed, for which there was no room.
constexpr std::chrono::seconds spectra_again_after{1};

} // namespace

void Session::on_subscribe_spectrum(const wire::SubscribeSpectrum& subscribe) {
    const std::uint32_t request_id = subscribe.request_id();
    if (const Result<void> fine = protocol::check(subscribe); !fine)
        return refuse(request_id, fine.error());
    if (spectra_in_making_ > 0 || outbox_.spectrum_waiting())
        return refuse(request_id,
                      {ErrorCode::too_many_requests, "an earlier spectrum is not all sent"});
    spectrum_wish_ = {.error_m = subscribe.error_m(),
                      .slope_error = subscribe.slope_error(),
                      .fields = sea::FieldSet::from_bits(subscribe.fields())};
    if (subscribe.fields() == 0)
        spectrum_wish_->fields = sea::surface_fields;
    spectra_sent_.clear();
    outbox_.stop_spectra(); // those of seas to come: they come with this one
    make_spectra(request_id);
}

void Session::make_spectra(std::optional<std::uint32_t> request_id) {
    ++spectra_in_making_;
    spectra_owed_.reset();
    const SpectrumRequest request{.wish = *spectrum_wish_,
                                  .asker = Asker(here_),
                                  .asked = request_id.has_value(),
                                  .has = spectra_sent_};
    if (const std::optional<GrantedSpectrum> held = core_.host.held_spectrum(request))
        return spectra_made(request_id, *held); // waits behind nothing that others have made
    if (!ask_behind([request](Host& host) { return host.spectrum(request); },
                    [request_id](Session& session, const Result<GrantedSpectrum>& granted) {
                        session.spectra_made(request_id, granted);
                    }))
        spectra_made(request_id, Error{Refusal::busy, "too many spectra wait to be made already"});
}

void Session::make_owed_spectra() {
    if (spectra_owed_ && spectrum_wish_ && spectra_in_making_ == 0 &&
        std::chrono::steady_clock::now() >= *spectra_owed_)
        make_spectra({});
}

void Session::spectra_made(std::optional<std::uint32_t> request_id,
                           const Result<GrantedSpectrum>& granted) {
    --spectra_in_making_;
    if (!spectrum_wish_) {
        if (request_id)
            refuse(*request_id, {ErrorCode::bad_value, "given up by Unsubscribe"});
        return;
    }
    if (!granted) {
        if (request_id) {
            spectrum_wish_.reset();
            refuse(*request_id, granted.error());
        } else if (granted.error().is(Refusal::busy)) {
            // It has a right to them.
            spectra_owed_ = std::chrono::steady_clock::now() + spectra_again_after;
            link_.send_more(); // sees that something is owed
        }
        return;
    }
    std::vector<EncodedSpectrumPtr> sent;
    const auto has = [this](std::uint32_t epoch) {
        return std::ranges::find(spectra_sent_, epoch) != spectra_sent_.end();
    };
    for (const EncodedSpectrumPtr& spectrum : granted->spectra) {
        if (has(spectrum->epoch) || (spectrum->ends_epoch != 0 && has(spectrum->ends_epoch)))
            continue;
        spectra_sent_.push_back(spectrum->epoch);
        if (spectra_sent_.size() > limits::sea_states_told)
            spectra_sent_.erase(spectra_sent_.begin());
        sent.push_back(spectrum);
    }
    for (const EncodedSpectrumPtr& spectrum : sent)
        tell_of(spectrum->epoch);
    if (request_id) // goes before them: the client counts them from then on
        reply(protocol::spectrum_subscribed(*request_id,
                                            {.error_m = granted->error_m,
                                             .slope_error = granted->slope_error,
                                             .fields = granted->fields,
                                             .spectra = static_cast<std::uint32_t>(sent.size()),
                                             .why = granted->why}));
    for (const EncodedSpectrumPtr& spectrum : sent)
        if (request_id)
            outbox_.push_spectrum(spectrum);
        else // of a sea to come
            outbox_.push_paced_spectrum(spectrum, core_.host.sea_time_us());
    link_.send_more();
}

} // namespace seaway::server
