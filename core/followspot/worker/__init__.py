"""The runtime of one worker: it fires stages when their inputs are ready and accounts for every message.

Entry: `scheduler.Scheduler`, which `build.build_worker` builds from a plan, with its stages. It starts no
process and knows no host; `followspot.host` does.
"""
