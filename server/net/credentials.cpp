// SPDX-License-Identifier: Apache-2.0
#include "server/net/credentials.h"

#include <algorithm>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ssl/context.hpp>
#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include "base/pem_file.h"
#include "protocol/token_file.h"

namespace seaway::server {
namespace {

namespace ssl = boost::asio::ssl;

/// Of the handshake, which takes some six, of new keys and of attempts to begin anew, in the life of a connection: some peers take new
/// keys after 2^24 messages. None of them shows above TLS, so no limit of bytes counts them, and each costs some microseconds.
constexpr std::intptr_t handshake_messages_max = 100;

/// By OpenSSL, of each message of its own: too many end the connection, as if its peer had closed it.
void count_handshakes(int sends, int, int kind, const void*, std::size_t, SSL* peer, void*) {
    static const int index = SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, nullptr);
    if (sends != 0 || kind != SSL3_RT_HANDSHAKE)
        return;
    const auto count = reinterpret_cast<std::intptr_t>(SSL_get_ex_data(peer, index)) + 1;
    SSL_set_ex_data(peer, index, reinterpret_cast<void*>(count));
    if (count > handshake_messages_max)
        SSL_set_shutdown(peer, SSL_RECEIVED_SHUTDOWN | SSL_SENT_SHUTDOWN);
}

/// Of TLS 1.2; those of 1.3 are all of this kind.
constexpr const char* cipher_suites = "ECDHE+AESGCM:ECDHE+CHACHA20";

Result<std::shared_ptr<ssl::context>> new_context() {
    const auto tls = std::make_shared<ssl::context>(ssl::context::tls_server);
    boost::system::error_code error;
    tls->set_options(ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1 | ssl::context::no_sslv2 |
                         ssl::context::no_sslv3 | SSL_OP_NO_RENEGOTIATION |
                         SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_NO_TICKET,
                     error);
    // Nobody takes a session up again: the key of a ticket, or a session that is kept, opens what was said in all of them.
    SSL_CTX_set_session_cache_mode(tls->native_handle(), SSL_SESS_CACHE_OFF);
    SSL_CTX_set_num_tickets(tls->native_handle(), 0);
    if (SSL_CTX_set_cipher_list(tls->native_handle(), cipher_suites) != 1)
        return Error{fmt::format("this OpenSSL has none of the cipher suites {}", cipher_suites)};
    SSL_CTX_set_msg_callback(tls->native_handle(), count_handshakes);
    return tls;
}

/// The key is that of a certificate, which has to be there before.
class Reading {
  public:
    explicit Reading(const NetOptions& options) : options_(options) {}

    CredentialsRead read() {
        token("--client-token-file", options_.client_token_file, credentials_.tokens.client);
        token("--admin-token-file", options_.admin_token_file, credentials_.tokens.admin);
        if (!credentials_.tokens.admin.empty() &&
            credentials_.tokens.admin == credentials_.tokens.client)
            fail(
                files_.back(),
                Error{fmt::format("--admin-token-file {}: the same token as in --client-token-file "
                                  "{}, which would make every client an administrator",
                                  options_.admin_token_file, options_.client_token_file)});
        if (options_.tls_cert_file.empty() != options_.tls_key_file.empty())
            fail(Error{"--tls-cert and --tls-key belong together: give both or neither"});
        else if (!options_.tls_cert_file.empty())
            certificate();
        if (error_)
            return {*std::move(error_), std::move(files_)};
        return {std::move(credentials_), std::move(files_)};
    }

  private:
    void fail(Error error) {
        if (!error_)
            error_ = std::move(error);
    }
    CredentialFile& file(const char* option, const std::string& path) {
        return files_.emplace_back(CredentialFile{option, path, fingerprint_of(path)});
    }
    void fail(CredentialFile& file, const Error& error) {
        file.failed = error;
        fail(error);
    }
    void token(const char* option, const std::string& path, std::string& to) {
        if (path.empty())
            return;
        CredentialFile& read = file(option, path);
        if (Result<std::string> found = protocol::read_token_file(path))
            to = *std::move(found);
        else
            fail(read, found.error());
    }
    /// `taken` says in `error` what is wrong with the text.
    template <class Taken>
    bool use(CredentialFile& file, const Result<std::string>& text, const char* expected,
             const Taken& taken, const boost::system::error_code& error) {
        if (text)
            taken(boost::asio::buffer(*text));
        if (text && !error)
            return true;
        fail(file, Error{fmt::format("{} {}: {}; {}", file.option, file.path,
                                     text ? error.message() : text.error().message, expected)});
        return false;
    }
    void certificate() {
        Result<std::shared_ptr<ssl::context>> made = new_context();
        if (!made)
            return fail(made.error());
        const std::shared_ptr<ssl::context> tls = *made;
        boost::system::error_code error;
        // The text is read here: OpenSSL would wait for a pipe, and ask a terminal for a pass phrase.
        CredentialFile& chain = file("--tls-cert", options_.tls_cert_file);
        const bool has_chain = use(
            chain, read_pem_file(chain.path), "a PEM certificate chain is expected",
            [&](const auto& text) { tls->use_certificate_chain(text, error); }, error);
        CredentialFile& key = file("--tls-key", options_.tls_key_file);
        if (!has_chain) // there is nothing that it could be the key of
            return;
        if (!use(
                key, read_pem_key_file(key.path), "the PEM key of the certificate is expected",
                [&](const auto& text) { tls->use_private_key(text, ssl::context::pem, error); },
                error))
            return;
        // OpenSSL takes a key of another type than the certificate's, for a certificate that might follow.
        if (SSL_CTX_check_private_key(tls->native_handle()) != 1) {
            ERR_clear_error();
            return fail(key, Error{fmt::format("--tls-key {}: not the key of the certificate in {}",
                                               key.path, options_.tls_cert_file)});
        }
        credentials_.tls = tls;
    }

    const NetOptions& options_;
    Credentials credentials_;
    std::vector<CredentialFile> files_;
    std::optional<Error> error_;
};

} // namespace

CredentialsRead read_credentials(const NetOptions& options) {
    return Reading(options).read();
}

std::vector<FileReadAgain> compare(const std::vector<CredentialFile>& in_use,
                                   const std::vector<CredentialFile>& now) {
    const auto failed = std::ranges::find_if(
        now, [](const CredentialFile& file) { return file.failed.has_value(); });
    std::vector<FileReadAgain> all;
    for (const CredentialFile& file : now) {
        FileReadAgain& one =
            all.emplace_back(FileReadAgain{file.option, file.path, ReadAgain::read_again});
        const auto before = std::ranges::find(in_use, file.option, &CredentialFile::option);
        if (file.failed) {
            one.outcome = ReadAgain::failed;
            one.why = file.failed->message;
        } else if (before != in_use.end() && file.fingerprint &&
                   before->fingerprint == file.fingerprint) {
            one.outcome = ReadAgain::unchanged;
        } else if (failed != now.end()) {
            one.outcome = ReadAgain::kept;
            one.why = failed->option + " failed, and all are taken or none";
        }
    }
    return all;
}

} // namespace seaway::server
