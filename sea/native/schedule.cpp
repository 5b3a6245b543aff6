// SPDX-License-Identifier: Apache-2.0
#include "sea/native/schedule.h"

namespace seaway::sea::native {

std::vector<ScheduledPass> schedule(std::span<const TaskChunks> tasks, std::size_t held) {
    std::vector<int> columns_at(tasks.size()), rows_at(tasks.size());
    std::vector<ScheduledPass> passes;
    const auto add = [&](const ScheduledPass& pass) {
        passes.push_back(pass);
        return static_cast<int>(passes.size()) - 1;
    };
    const std::size_t ahead = held - 1;
    for (std::size_t i = 0; i < tasks.size() + ahead; ++i) {
        if (i < tasks.size())
            columns_at[i] =
                add({Pass::columns, i, tasks[i].columns, i >= held ? rows_at[i - held] : -1});
        if (i >= ahead) {
            const std::size_t task = i - ahead;
            rows_at[task] = add({Pass::rows, task, tasks[task].rows, columns_at[task]});
        }
    }
    return passes;
}

} // namespace seaway::sea::native
