// SPDX-License-Identifier: Apache-2.0
// The command line of the server: every option away from its default, and what makes no sense.
#include <algorithm>
#include <chrono>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gpu/device_info.h"
#include "protocol/messages.h"
#include "server/devices.h"
#include "server/options.h"
#include "tests/support/folder.h"

namespace seaway::server {
namespace {

std::variant<Options, int> options_of(std::vector<std::string> words, std::string* said = nullptr) {
    words.insert(words.begin(), "seaway-server");
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    testing::internal::CaptureStderr();
    auto read = read_options(static_cast<int>(words.size()), pointers.data());
    const std::string error = testing::internal::GetCapturedStderr();
    if (said)
        *said = error;
    return read;
}

TEST(ServerOptions, each_goes_where_it_says_and_has_its_default) {
    const auto plain = options_of({"a.toml"});
    ASSERT_TRUE(std::holds_alternative<Options>(plain));
    const auto& bare = std::get<Options>(plain);
    EXPECT_EQ(bare.scene, "a.toml");
    EXPECT_EQ(bare.net.listen, "127.0.0.1:9430");
    EXPECT_EQ(bare.device, "auto");
    EXPECT_EQ(bare.net.tls_cert_file + bare.net.tls_key_file + bare.net.admin_token_file +
                  bare.net.client_token_file + bare.net.health_listen,
              "");
    EXPECT_TRUE(bare.net.allowed_origins.empty());
    EXPECT_EQ(bare.readback, "exact");
    EXPECT_FALSE(bare.validation);
    EXPECT_EQ(bare.memory_mb, 0) << "what the sea needs";
    EXPECT_EQ(bare.work_rate, 1) << "who waits for answers is never refused";
    EXPECT_EQ(bare.work_burst_s, 10);
    EXPECT_EQ(bare.answer_threads, 0) << "what the machine has";
    const auto read = options_of({"--listen",
                                  "[::]:1",
                                  "--device",
                                  "2",
                                  "--tls-cert",
                                  "c.pem",
                                  "--tls-key",
                                  "k.pem",
                                  "--admin-token-file",
                                  "admin",
                                  "--client-token-file",
                                  "client",
                                  "--memory-mb",
                                  "300",
                                  "--work-rate",
                                  "0.25",
                                  "--work-burst",
                                  "3",
                                  "--validation",
                                  "b.toml",
                                  "--answer-threads",
                                  "5",
                                  "--readback",
                                  "rounded"});
    ASSERT_TRUE(std::holds_alternative<Options>(read));
    const auto& all = std::get<Options>(read);
    EXPECT_EQ(all.scene, "b.toml");
    EXPECT_EQ(all.net.listen, "[::]:1");
    EXPECT_EQ(all.device, "2");
    EXPECT_EQ(all.net.tls_cert_file, "c.pem");
    EXPECT_EQ(all.net.admin_token_file, "admin");
    EXPECT_EQ(all.net.client_token_file, "client");
    EXPECT_EQ(all.net.tls_key_file, "k.pem");
    EXPECT_EQ(all.readback, "rounded");
    EXPECT_TRUE(all.validation);
    EXPECT_EQ(all.memory_mb, 300);
    EXPECT_EQ(all.work_rate, 0.25);
    EXPECT_EQ(all.work_burst_s, 3);
    EXPECT_EQ(all.answer_threads, 5);
    EXPECT_EQ(options_of({"--device", "list"}).index(), 0u) << "a list needs no scene";
}

// Naive: the older name of the option forgets what belongs to the journal beside it, and NATS is spoken to in the clear.
TEST(ServerOptions, a_journal_by_its_older_name_keeps_what_else_is_said_of_it) {
    const auto read =
        options_of({"a.toml", "--data-dir", "nats://h/w", "--journal-tls-ca", "ca.pem",
                    "--journal-credentials", "who", "--journal-replicas", "3"});
    ASSERT_TRUE(std::holds_alternative<Options>(read));
    const JournalPlace& journal = std::get<Options>(read).journal;
    EXPECT_EQ(journal.option, "--data-dir");
    EXPECT_EQ(journal.where, "nats://h/w");
    EXPECT_EQ(journal.tls_ca_file, "ca.pem");
    EXPECT_EQ(journal.credentials_file, "who");
    EXPECT_EQ(journal.replicas, 3);
}

// Naive: that there are two is looked at when file and line are one list of words.
TEST(ServerOptions, a_journal_of_the_command_line_wins_over_that_of_a_file_whatever_it_is_called) {
    const std::string file = tests::folder().write("journal.toml", "data-dir = \"/of/the/file\"\n");
    const std::string other = tests::folder().write("other.toml", "journal = \"/of/the/file\"\n");
    for (const std::string& config : {file, other})
        for (const char* name : {"--journal", "--data-dir"}) {
            const auto read = options_of({"a.toml", "--config", config, name, "/of/the/line"});
            ASSERT_TRUE(std::holds_alternative<Options>(read)) << config << ' ' << name;
            EXPECT_EQ(std::get<Options>(read).journal.where, "/of/the/line");
        }
    std::string said;
    const auto both = options_of({"a.toml", "--journal", "a", "--data-dir", "b"}, &said);
    EXPECT_FALSE(std::holds_alternative<Options>(both));
    EXPECT_NE(said.find("both say where the journal is"), std::string::npos) << said;
}

TEST(ServerOptions, what_a_file_asks_for_and_cannot_be_had_is_named_with_file_and_line) {
    for (const auto& [text, says] :
         {std::pair("# none\nrequest-bytes-per-address = 5\n",
                    ":2: --request-bytes-per-address 5: "),
          std::pair("data-dir = \"a\"\njournal = \"b\"\n", ":1: --data-dir and --journal both"),
          std::pair("# late\ndrain = \"x\"\n", ":2: drain: 'x' is not a number")}) {
        const std::string file = tests::folder().write("cannot.toml", text);
        std::string said;
        const auto read = options_of({"a.toml", "--config", file}, &said);
        EXPECT_FALSE(std::holds_alternative<Options>(read)) << text;
        EXPECT_NE(said.find(file + says), std::string::npos) << said;
    }
}

// The numbers of docs/security.md, and of docs/operations.md where they have a flag.
TEST(ServerOptions, limits_are_by_default_what_the_page_on_security_says) {
    const auto plain = options_of({"a.toml"});
    ASSERT_TRUE(std::holds_alternative<Options>(plain));
    const NetOptions& net = std::get<Options>(plain).net;
    EXPECT_EQ(net.connections_per_address, 320);
    EXPECT_EQ(net.sessions_without_hello_per_address, 32);
    EXPECT_EQ(net.wrong_tokens_per_address, 10);
    EXPECT_EQ(net.wrong_tokens_refill, std::chrono::minutes(1));
    EXPECT_EQ(net.request_bytes_per_s_per_address, 128.0 * 1024 * 1024);
    EXPECT_GE(net.request_bytes_per_s_per_address, 5e6 * sizeof(wire::Point))
        << "what is asked about in a second";
    EXPECT_EQ(net.hello_deadline, std::chrono::seconds(2));
    EXPECT_EQ(net.http_deadline, std::chrono::seconds(10));
}

TEST(ServerOptions, limits_of_addresses_and_pages_that_may_come_each_have_a_flag) {
    const auto read = options_of(
        {"--health-listen", "127.0.0.1:2", "--connections-max", "11", "--sessions-max", "12",
         "--connections-per-address", "13", "--sessions-without-hello-per-address", "14",
         "--wrong-tokens-per-address", "15", "--request-bytes-per-address", "300000.5",
         "--allow-origin", "https://a.example", "--allow-origin", "https://b.example", "b.toml"});
    ASSERT_TRUE(std::holds_alternative<Options>(read));
    const auto& all = std::get<Options>(read);
    EXPECT_EQ(all.scene, "b.toml") << "an origin is one word";
    EXPECT_EQ(all.net.health_listen, "127.0.0.1:2");
    EXPECT_EQ(all.net.connections_max, 11);
    EXPECT_EQ(all.net.sessions_max, 12);
    EXPECT_EQ(all.net.connections_per_address, 13);
    EXPECT_EQ(all.net.sessions_without_hello_per_address, 14);
    EXPECT_EQ(all.net.wrong_tokens_per_address, 15);
    EXPECT_EQ(all.net.request_bytes_per_s_per_address, 300000.5);
    EXPECT_EQ(all.net.allowed_origins,
              (std::vector<std::string>{"https://a.example", "https://b.example"}));
}

TEST(ServerOptions, what_makes_no_sense_is_exit_code_2_and_one_line_that_names_it) {
    const std::pair<std::vector<std::string>, const char*> cases[] = {
        {{}, "SCENE.toml is required"},
        {{"--device", "native"}, "SCENE.toml is required"},
        {{"a.toml", "b.toml"}, "b.toml"},
        {{"a.toml", "--tls-cert", "c.pem"}, "--tls-key"},
        {{"a.toml", "--tls-key", "k.pem"}, "--tls-cert"},
        {{"a.toml", "--listen", ""}, "--listen"},
        {{"a.toml", "--connections-max", "0"}, "--connections-max"},
        {{"a.toml", "--connections-per-address", "-1"}, "--connections-per-address"},
        {{"a.toml", "--memory-mb", "-1"}, "--memory-mb"},
        {{"a.toml", "--memory-mb", "1e9"}, "--memory-mb"},
        {{"a.toml", "--work-rate", "0"}, "--work-rate"},
        {{"a.toml", "--readback", "half"}, "--readback"},
        {{"a.toml", "--answer-threads", "65"}, "--answer-threads"},
        {{"a.toml", "--work-burst", "-1"}, "--work-burst"},
        {{"a.toml", "--bogus"}, "--bogus"}};
    for (const auto& [words, named] : cases) {
        std::string said;
        const auto read = options_of(words, &said);
        ASSERT_TRUE(std::holds_alternative<int>(read)) << named;
        EXPECT_EQ(std::get<int>(read), 2);
        EXPECT_NE(said.find(named), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), said.size() - 1) << said;
    }
}

// What --device list prints is what --device takes: numbers in order, then the processor by its name.
TEST(DeviceList, has_a_line_for_each_device_in_order_and_the_processor_last) {
    const auto list = device_list();
    ASSERT_TRUE(list);
    std::istringstream lines(*list);
    std::string line;
    const auto devices = gpu::list_devices(); // none where there is no Vulkan
    const std::size_t count = devices ? devices->size() : 0;
    for (std::size_t i = 0; i < count; ++i) {
        ASSERT_TRUE(std::getline(lines, line));
        const gpu::DeviceInfo& device = (*devices)[i];
        ASSERT_NE(device.name, device.driver);
        const std::string known = std::to_string(i) + ": " + device.name + ", " + device.driver;
        EXPECT_EQ(line.substr(0, known.size()), known);
        const std::string rest = line.substr(std::min(known.size(), line.size()));
        EXPECT_EQ(rest.empty(), device.is_usable()) << line;
        EXPECT_NE(rest.find(device.unusable), std::string::npos) << line;
    }
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(line.substr(0, 8), "native: ");
    EXPECT_FALSE(std::getline(lines, line));
}

} // namespace
} // namespace seaway::server
