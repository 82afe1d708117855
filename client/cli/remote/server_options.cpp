#include "client/cli/remote/server_options.h"

#include "absl/strings/str_cat.h"

namespace dcloc::cli {

CLI::Option* AddServerOptions(CLI::App& command, client::ChannelOptions& options) {
  CLI::Option* server = command.add_option("--server", options.server, "Address of dcloc-server")
                            ->required()
                            ->type_name("HOST:PORT");
  command
      .add_option("--tls-ca", options.tls_ca,
                  "Authority of the server's certificate (PEM); without it, plaintext")
      ->type_name("FILE");
  command
      .add_option("--tls-cert", options.tls_cert,
                  "Own certificate (PEM), where the server asks for one")
      ->type_name("FILE");
  command.add_option("--tls-key", options.tls_key, "Its private key (PEM)")->type_name("FILE");
  command
      .add_option("--tls-server-name", options.tls_server_name,
                  "Name in the server's certificate, where it is not the host")
      ->type_name("NAME");
  command
      .add_option("--token-file", options.token_file,
                  "File with the token that says who calls; sent over TLS or on loopback only")
      ->envname("DCLOC_TOKEN_FILE")
      ->type_name("FILE");
  command
      .add_option("--tenant", options.tenant,
                  "Tenant to work in, for who may manage the server; else the caller's own")
      ->type_name("NAME");
  return server;
}

absl::Status NamingServer(absl::Status status, const client::ChannelOptions& server) {
  if (!absl::IsUnavailable(status) && !absl::IsDeadlineExceeded(status)) return status;
  return absl::Status(status.code(), absl::StrCat(server.server, ": ", status.message()));
}

}  // namespace dcloc::cli
