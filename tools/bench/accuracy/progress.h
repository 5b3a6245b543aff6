// SPDX-License-Identifier: Apache-2.0
// How far a long run has come, on stderr: a bar with the time left on a terminal, else a line now and
// then. For one thread.
#pragma once

#include <chrono>
#include <string>

namespace seaway::bench {

class Progress {
  public:
    explicit Progress(int steps);

    /// A step that takes long begins; `name` is shown.
    void begin(const std::string& name);
    /// A step is done; `skipped`: it needed no time and says nothing of those to come.
    void done(bool skipped = false);
    void finish();

  private:
    double seconds_left() const;

    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point last_line_;
    int steps_;
    int done_ = 0;
    int skipped_ = 0;
    bool terminal_;
};

} // namespace seaway::bench
