// SPDX-License-Identifier: Apache-2.0
// Asker: who waits for an answer, and whether somebody still does. A session that ends leaves
// questions behind; they are dropped instead of worked on, so that nobody keeps the server busy by
// asking and going away.
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

    /// The same one, who no longer asks this as soon as nobody holds `question`.
    Asker about(const std::shared_ptr<const void>& question) const {
        Asker asker = *this;
        asker.question_ = question;
        asker.may_give_up_ = true;
        return asker;
    }

    bool gone() const {
        return (may_go_ && here_.expired()) || (may_give_up_ && question_.expired());
    }

    /// It asks nothing any more, whatever it has asked.
    bool left() const { return may_go_ && here_.expired(); }

    /// Both are made of the same `here`; all who stay are the same one.
    bool same(const Asker& other) const {
        return !here_.owner_before(other.here_) && !other.here_.owner_before(here_);
    }

    /// For maps; those who are the same() are one key.
    struct Order {
        bool operator()(const Asker& a, const Asker& b) const {
            return a.here_.owner_before(b.here_);
        }
    };

  private:
    Asker() = default;

    std::weak_ptr<const void> here_;
    std::weak_ptr<const void> question_;
    bool may_go_ = false;
    bool may_give_up_ = false;
};

} // namespace seaway::server
