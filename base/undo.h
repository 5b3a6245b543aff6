// SPDX-License-Identifier: Apache-2.0
// Undo: what has to be taken back if the rest does not come about, by whichever way it ends, an exception included.
//
//     Undo restart([&] { walk.restart(); });
//     SEAWAY_TRY(made());
//     restart.keep();
#pragma once

#include <utility>

namespace seaway {

/// `back` must not throw.
template <class Back>
class Undo {
  public:
    explicit Undo(Back back) : back_(std::move(back)) {}
    ~Undo() {
        if (undoes_)
            back_();
    }
    Undo(const Undo&) = delete;
    Undo& operator=(const Undo&) = delete;

    /// It came about.
    void keep() { undoes_ = false; }

  private:
    Back back_;
    bool undoes_ = true;
};

} // namespace seaway
