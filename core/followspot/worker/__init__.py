"""The runtime of one worker: it fires stages when their inputs are ready and accounts for every message.

Entry: `worker.Worker`, built from a plan by `building.build_worker`. It starts no process and knows no host;
`followspot.host` does.
"""
