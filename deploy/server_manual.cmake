# cmake -DPROGRAM=... -DOUTPUT=... -P server_manual.cmake: the manual of dcloc-server, made of what the
# program says of itself, so that it cannot say anything else.
foreach(SUBCOMMAND "" "token")
  execute_process(COMMAND ${PROGRAM} ${SUBCOMMAND} --help
    OUTPUT_VARIABLE HELP COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "${PROGRAM}" "dcloc-server" HELP "${HELP}")
  string(REPLACE "\\" "\\e" HELP "${HELP}")
  string(REPLACE "-" "\\-" HELP "${HELP}")
  string(APPEND TEXT ".SH dcloc\\-server ${SUBCOMMAND}\n.EX\n${HELP}.EE\n")
endforeach()
file(WRITE ${OUTPUT} ".TH DCLOC\\-SERVER 8
.SH NAME
dcloc\\-server \\- localizes vehicles in radar maps, over gRPC
${TEXT}.SH SIGNALS
SIGTERM and SIGINT end it gracefully; SIGHUP reads the settings again that may change.
.SH FILES
.TP
/etc/dcloc/server.json
settings of the service
.TP
/var/lib/dcloc
its maps and identities
.SH SEE ALSO
dcloc(1)
")
