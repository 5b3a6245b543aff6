// SPDX-License-Identifier: Apache-2.0
// One slice of a question, on whichever thread has taken it.
#pragma once

#include "server/simulation/questions.h"

namespace seaway::server {

/// Works on it once, and puts it back, or ends it: answered, or refused where its asker has gone or the system
/// gives no memory or no thread. Nothing is thrown, but std::bad_alloc where who asked works on it himself and could not be told.
void work_on_slice(Questions& questions, Question question);
/// The same by another slice than its own.
void work_on_slice(Questions& questions, Question question, const std::function<bool()>& slice);

} // namespace seaway::server
