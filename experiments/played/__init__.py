"""Is the next experiment that a diagnosis proposes worth more than a random one of its length?"""
