"""The runtime of one worker: it fires stages when their inputs are ready and accounts for every message.

Entry: `scheduler.Worker`, built from a plan by `build.build_worker`. It starts no process and knows no host;
`followspot.host` does.
"""
