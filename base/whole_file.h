// SPDX-License-Identifier: Apache-2.0
// Files that come about whole or not at all: they are written beside, as PATH.part, and take their name when every byte
// is there. Whatever ends that, a full disk or a signal, what lay under the name stays.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace seaway {

/// `write` makes the file of the path that it is given. The error is its own, or says why in the words of check_replaceable() or
/// of the system, without a path; no part is left then, nor where `write` throws.
Result<void> write_whole_file(const std::string& path,
                              const std::function<Result<void>(const std::string&)>& write);

/// The same of these bytes.
Result<void> write_whole_file(const std::string& path, std::string_view bytes);

/// For who works long before he writes: would that go now? Nothing is left of the trial.
Result<void> check_whole_file(const std::string& path);

} // namespace seaway
