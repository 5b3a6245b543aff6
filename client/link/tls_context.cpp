// SPDX-License-Identifier: Apache-2.0
#include "client/link/tls_context.h"

#include <boost/asio/ssl/context.hpp>
#include <fmt/format.h>

#include "base/text_file.h"
#include "client/link/failure.h"

namespace seaway::client {

Result<std::shared_ptr<boost::asio::ssl::context>> tls_context(const std::string& ca_file) {
    using boost::asio::ssl::context;
    auto made = std::make_shared<context>(context::tls_client);
    boost::system::error_code problem;
    made->set_options(context::no_tlsv1 | context::no_tlsv1_1, problem);
    made->set_default_verify_paths(problem);
    if (ca_file.empty())
        return made;
    const Result<void> regular = check_regular_file(ca_file); // OpenSSL waits for a pipe
    if (regular)
        made->load_verify_file(ca_file, problem);
    if (!regular || problem)
        return failed(Failure::bad_argument,
                      fmt::format("certificates in '{}': {}", ca_file,
                                  regular ? problem.message() : regular.error().message));
    return made;
}

} // namespace seaway::client
