// SPDX-License-Identifier: Apache-2.0
// Pauses: what takes some milliseconds to make says after each row how far it has come, so that who has it made may let
// others go first now and then. What is made is the same.
#pragma once

#include <cstddef>

namespace seaway::sea {

class Pauses {
  public:
    using Pause = void (*)();
    /// Texels that are written or read between two pauses: some 0.2 ms.
    static constexpr std::size_t between = 16'384;

    /// `pause` is called on the thread that works; null: never.
    explicit Pauses(Pause pause) : pause_(pause) {}

    void after(std::size_t texels) {
        done_ += texels;
        if (pause_ == nullptr || done_ < between)
            return;
        done_ = 0;
        pause_();
    }

  private:
    Pause pause_;
    std::size_t done_ = 0;
};

} // namespace seaway::sea
