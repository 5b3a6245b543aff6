// SPDX-License-Identifier: Apache-2.0
#include "server/progress.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/messages.h"
#include "server/world.h"

namespace seaway::server {

bool Progress::comes_on(const Health& simulation,
                        std::chrono::steady_clock::duration sockets_silent) {
    std::string why;
    if (!simulation.live)
        why = simulation.why;
    else if (sockets_silent >= stuck_after)
        why = fmt::format("the sockets have not come on for {} s",
                          std::chrono::duration_cast<std::chrono::seconds>(sockets_silent).count());
    if (stuck_.empty() && !why.empty())
        spdlog::critical("event=stuck why={}", in_quotes(why));
    if (!stuck_.empty() && why.empty())
        spdlog::warn("event=comes_on_again");
    stuck_ = why;
    return stuck_.empty();
}

} // namespace seaway::server
