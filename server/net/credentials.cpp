// SPDX-License-Identifier: Apache-2.0
#include "server/net/credentials.h"

#include <boost/asio/ssl/context.hpp>
#include <fmt/format.h>

namespace seaway::server {
namespace {

namespace ssl = boost::asio::ssl;

/// Of TLS 1.2; those of 1.3 are all of this kind.
constexpr const char* cipher_suites = "ECDHE+AESGCM:ECDHE+CHACHA20";

Result<std::shared_ptr<ssl::context>> load_certificate(const NetOptions& options) {
    if (options.tls_cert_file.empty() != options.tls_key_file.empty())
        return Error{"--tls-cert and --tls-key belong together: give both or neither"};
    if (options.tls_cert_file.empty())
        return std::shared_ptr<ssl::context>();
    const auto tls = std::make_shared<ssl::context>(ssl::context::tls_server);
    boost::system::error_code error;
    tls->set_options(ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1 | ssl::context::no_sslv2 |
                         ssl::context::no_sslv3 | SSL_OP_NO_RENEGOTIATION |
                         SSL_OP_CIPHER_SERVER_PREFERENCE,
                     error);
    if (SSL_CTX_set_cipher_list(tls->native_handle(), cipher_suites) != 1)
        return Error{fmt::format("this OpenSSL has none of the cipher suites {}", cipher_suites)};
    tls->use_certificate_chain_file(options.tls_cert_file, error);
    if (error)
        return Error{fmt::format("--tls-cert {}: {}; a PEM certificate chain is expected",
                                 options.tls_cert_file, error.message())};
    tls->use_private_key_file(options.tls_key_file, ssl::context::pem, error);
    if (error)
        return Error{fmt::format("--tls-key {}: {}; the PEM key of the certificate is expected",
                                 options.tls_key_file, error.message())};
    return tls;
}

} // namespace

Result<Credentials> load_credentials(const NetOptions& options) {
    Credentials credentials;
    SEAWAY_TRY_LET(credentials.tokens, load_tokens(options));
    SEAWAY_TRY_LET(credentials.tls, load_certificate(options));
    return credentials;
}

std::vector<CredentialFile> credential_files(const NetOptions& options) {
    std::vector<CredentialFile> files;
    for (const auto& [option, path] : {std::pair("--client-token-file", &options.client_token_file),
                                       std::pair("--admin-token-file", &options.admin_token_file),
                                       std::pair("--tls-cert", &options.tls_cert_file),
                                       std::pair("--tls-key", &options.tls_key_file)})
        if (!path->empty())
            files.push_back({option, *path});
    return files;
}

} // namespace seaway::server
