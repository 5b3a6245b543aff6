// SPDX-License-Identifier: Apache-2.0
// Thin C++ (17 and later) over client/seaway.h: ownership and vectors, nothing more. It needs only
// that header and the library. Errors are thrown as seaway::SeaError; everything else, units and
// thread safety too, is as the C header says.
//
//     seaway::Sea sea("ws://localhost:9430");
//     sea.subscribe();
//     const seaway_answer water = sea.sample({12.0, -40.0, sea.now_us()});
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "seaway.h" // beside this file, here and where it is installed

namespace seaway {

class SeaError : public std::runtime_error {
  public:
    explicit SeaError(seaway_code why) : std::runtime_error(seaway_last_error()), code_(why) {}
    seaway_code code() const noexcept { return code_; }

  private:
    seaway_code code_;
};

class Sea {
  public:
    explicit Sea(const std::string& url, const seaway_connect_options& options = {}) {
        seaway_client* client = nullptr;
        require(seaway_connect(url.c_str(), &options, &client));
        client_.reset(client);
    }

    bool is_connected() const { return seaway_is_connected(client_.get()) != 0; }
    double retry_after_s() const { return seaway_retry_after_s(client_.get()); }
    seaway_status status() const {
        seaway_status status{};
        status.size = sizeof(status);
        require(seaway_get_status(client_.get(), &status));
        return status;
    }
    int64_t now_us() { return seaway_now_us(client_.get()); }

    seaway_clock_status clock() const {
        seaway_clock_status status{};
        require(seaway_clock(client_.get(), &status));
        return status;
    }
    seaway_sea at(int64_t time_us) const {
        seaway_sea sea{};
        require(seaway_sea_at(client_.get(), time_us, &sea));
        return sea;
    }

    std::vector<seaway_answer> query(const std::vector<seaway_point>& points, bool exact = false,
                                     double timeout_s = 0) {
        std::vector<seaway_answer> answers(points.size());
        require(seaway_query(client_.get(), points.data(), points.size(), exact ? 1 : 0, timeout_s,
                             answers.data()));
        return answers;
    }

    void subscribe(const seaway_subscription& subscription = {}) {
        require(seaway_subscribe(client_.get(), &subscription));
    }
    void unsubscribe() { require(seaway_unsubscribe(client_.get())); }
    void hold(const std::vector<int64_t>& times_us, double timeout_s = 0) {
        require(seaway_hold(client_.get(), times_us.data(), times_us.size(), timeout_s));
    }

    std::vector<seaway_answer> sample(const std::vector<seaway_point>& points) const {
        std::vector<seaway_answer> answers(points.size());
        require(seaway_sample(client_.get(), points.data(), points.size(), answers.data()));
        return answers;
    }
    seaway_answer sample(const seaway_point& point) const {
        seaway_answer answer{};
        require(seaway_sample(client_.get(), &point, 1, &answer));
        return answer;
    }

    seaway_client* handle() const { return client_.get(); }

  private:
    struct Disconnect {
        void operator()(seaway_client* client) const { seaway_disconnect(client); }
    };
    static void require(seaway_code code) {
        if (code != SEAWAY_OK)
            throw SeaError(code);
    }

    std::unique_ptr<seaway_client, Disconnect> client_;
};

} // namespace seaway
