// SPDX-License-Identifier: Apache-2.0
// Asker: whether somebody still waits for an answer. A session that ends leaves questions behind; they
// are dropped instead of worked on, so that nobody keeps the server busy by asking and going away.
//
// A value; gone() from any thread.
#pragma once

#include <memory>

namespace seaway::server {

class Asker {
  public:
    /// One who never goes. To be said: who forgets to hand an asker on would mean this one.
    static Asker who_stays() { return {}; }
    /// One who is there for as long as somebody holds `here`.
    explicit Asker(const std::shared_ptr<const void>& here) : here_(here), may_go_(true) {}

    bool gone() const { return may_go_ && here_.expired(); }

  private:
    Asker() = default;

    std::weak_ptr<const void> here_;
    bool may_go_ = false;
};

} // namespace seaway::server
