// SPDX-License-Identifier: Apache-2.0
#include "server/refused_changes.h"

#include "server/host/metrics_text.h"
#include "server/host/refusal.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {
namespace {

std::string_view reason_of(const Error& why) {
    if (why.is(Refusal::bad_value))
        return "bad_value";
    if (why.is(Refusal::busy))
        return "busy";
    if (why.is(Refusal::not_offered))
        return "not_offered";
    if (why.is(CourseError::full))
        return "full";
    return why.is(Refusal::gone) ? "gone" : "unwritten";
}

} // namespace

void RefusedChanges::count(const Error& why) {
    const std::scoped_lock lock(mutex_);
    ++counts_.at(reason_of(why));
}

RefusedChanges::Counts RefusedChanges::counts() const {
    const std::scoped_lock lock(mutex_);
    return counts_;
}

std::string metrics_text(const RefusedChanges::Counts& refused) {
    MetricsText text;
    text.each("changes_refused_total", "reason",
              "Changes of the sea that were asked for and not made.", refused);
    return text.take();
}

} // namespace seaway::server
