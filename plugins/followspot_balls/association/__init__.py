"""Which targets candidates show, and whether they exist, weighed over all views (Jin & Qian 2008, 3.8)."""
