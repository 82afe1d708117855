// Debian's gRPC is not built for the thread sanitizer, which therefore does not see how gRPC's
// threads hand things to each other. What is left is what our own code shares.
#ifdef __SANITIZE_THREAD__

extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }

extern "C" const char* __tsan_default_suppressions() {
  return "called_from_lib:libgrpc.so\n"
         "called_from_lib:libgrpc++.so\n"
         "called_from_lib:libprotobuf.so\n"
         "race_top:^grpc::\n"
         "race_top:^google::protobuf\n"
         "race:libgrpc++.so\n"
         "race:grpc_event_engine::\n"
         // gRPC's threads get the services from the thread that built them.
         "race:::MapService::MapService\n"
         "race:::LocalizationService::LocalizationService\n"
         "race:::AdminService::AdminService\n";
}

#endif
